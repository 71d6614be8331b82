"""A person who shows what a world asks for, and the worlds in which that can be shown."""

from dataclasses import dataclass

import numpy as np

from benchmarks.planted.episode import POLICY_HZ, Attempt, attempted
from benchmarks.planted.world import EACH, NAMES, World, drawn

# of a person: jitter of the hand as a share of the reach, its time, correction of what is seen
HAND, HAND_S, CORRECTS_PER_S = 0.04, 0.08, 4.0
HASTE = 0.15  # spread of the logarithm of a person's time
DWELLS_S = 0.1
SHOWN = 50  # demonstrations
TRIED, SUCCEED = 4, 3  # a world counts if a person succeeds so often


@dataclass(frozen=True)
class Demonstration:
    """Rows (rows, n) of what was recorded, and (ticks, …) of what a policy learns from.

    Attributes:
        q, dq: measured; torque: that the controller asked for beside what carries the weight.
        observation: at `POLICY_HZ`.
    """

    q: np.ndarray
    dq: np.ndarray
    torque: np.ndarray
    observation: np.ndarray


def worlds(seed: int) -> list[World]:
    """All of a seed: of each robot `EACH`, drawn until a person can do it."""
    found = []
    for robot in NAMES:
        for index in range(EACH):
            again = 0
            while not possible(world := drawn(seed, robot, index, again)):
                again += 1
            found.append(world)
    return found


def possible(world: World) -> bool:
    """Whether a person succeeds."""
    return sum(shown(world, i) is not None for i in range(TRIED)) >= SUCCEED


def demonstrations(world: World, count: int = SHOWN) -> list[Demonstration]:
    """Those that succeed."""
    found: list[Demonstration] = []
    number = 0
    while len(found) < count:
        if (one := shown(world, number)) is not None:
            found.append(one)
        number += 1
    return found


def shown(world: World, number: int) -> Demonstration | None:
    """An attempt of a person, None if it fails."""
    rng = world.rng(0, number)
    attempt = Attempt.drawn(world, rng)
    kp, kd = world.recorded_kp, world.recorded_kd
    trace = attempted(attempt, kp, kd, Person(attempt, rng), rng)
    if not attempt.success:
        return None
    q, dq = np.array(trace.q), np.array(trace.dq)
    command = np.repeat(trace.command, len(q) // len(trace.command), axis=0)
    return Demonstration(q, dq, kp * (command - q) - kd * dq, np.array(trace.observation))


class Person:
    """Leads the arm by eye: smooth ways in a time of their own, an unsteady hand, corrections."""

    def __init__(self, attempt: Attempt, rng: np.random.Generator):
        self.attempt, self.rng = attempt, rng
        self.seconds = attempt.world.seconds * np.exp(HASTE * rng.normal(size=2))
        n = len(attempt.start)
        self.hand, self.corrected = np.zeros((2, n)), np.zeros(n)
        self.began, self.way, self.time = 0.0, 0, 0.0
        keep = np.exp(-1 / (POLICY_HZ * HAND_S))
        # root of the variance that two low-passes leave of white noise: Σ ((1−k)² (i+1) kⁱ)²
        self.calm = (1 - keep) ** 2 * np.sqrt((1 + keep**2) / (1 - keep**2) ** 3)

    def __call__(self, observation: np.ndarray, link: np.ndarray) -> np.ndarray:
        """The command at the next tick of `POLICY_HZ`."""
        attempt, period = self.attempt, 1 / POLICY_HZ
        reach = attempt.world.reach
        way = [attempt.start, attempt.via, attempt.goal][self.way : self.way + 2]
        share = min((self.time - self.began) / self.seconds[self.way], 1.0)
        wanted = way[0] + share**3 * (10 - 15 * share + 6 * share**2) * (way[1] - way[0])
        # white noise through two low-passes, one after the other
        keep = np.exp(-period / HAND_S)
        pushed = self.rng.normal(size=len(reach)) * HAND * reach
        for i in range(2):
            self.hand[i] += (1 - keep) * ((pushed, self.hand[0])[i] - self.hand[i])
        wanted = wanted + self.hand[1] / self.calm
        self.corrected = self.corrected + CORRECTS_PER_S * period * (wanted - link)
        self.time += period
        over = self.time - self.began > self.seconds[self.way] + DWELLS_S
        if self.way == 0 and over and attempt.passed:
            self.began, self.way = self.time, 1
        return wanted + self.corrected
