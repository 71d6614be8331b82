"""One attempt in a world: through a place, then to another and hold there.

The robot starts at rest about home. Its links have to come to a first place, and then to stay at a
second for `HELD_S`, each within a tolerance, before `HORIZON` times what a person takes. Both
places are drawn for each attempt, and told. What decides how often gains succeed: how well commands
of a policy lead the arm there through the loop with its hidden effects, how far its errors carry
the arm off, and how it comes back.
"""

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from benchmarks.hidden_effects.generator import VELOCITY_NOISE_PER_S, Machine
from benchmarks.planted.world import World

PHYSICS_HZ = 2000
POLICY_HZ = 50
ROWS_HZ = 200  # of what is recorded
SPREAD = 0.3  # share of the reach, of starts and of both places
HELD_S = 0.2
HORIZON = 2.5  # times the person's time for both ways
REST_S = 0.3  # under the first command, before the attempt begins
LOST_RAD = 6.0  # from home: it ran away


@dataclass
class Attempt:
    """What is asked for, and how far it has come.

    Attributes:
        start, via, goal: (n,) rad.
        passed: whether the first place was reached; held: ticks at the second one.
    """

    world: World
    start: np.ndarray
    via: np.ndarray
    goal: np.ndarray
    passed: bool = False
    held: int = 0
    success: bool = False

    @staticmethod
    def drawn(world: World, rng: np.random.Generator) -> "Attempt":
        """About the middles of a world."""
        middles = [0.0, world.via, world.goal]
        places = [
            world.home + world.reach * (middle + SPREAD * rng.uniform(-1, 1, len(world.home)))
            for middle in middles
        ]
        return Attempt(world, *places)

    def judge(self, q: np.ndarray) -> None:
        """At a tick of the policy, by where the links are [rad]."""
        self.passed = self.passed or self.near(q, self.via)
        there = self.passed and self.near(q, self.goal)
        self.held = self.held + 1 if there else 0
        self.success = self.success or self.held >= HELD_S * POLICY_HZ

    def near(self, q: np.ndarray, place: np.ndarray) -> bool:
        """Whether the links are at a place."""
        shares = (q - place) / self.world.reach
        return bool(np.sqrt(np.mean(shares**2)) < self.world.tolerance)

    @property
    def ticks(self) -> int:
        """That it may last."""
        return round(HORIZON * 2 * self.world.seconds * POLICY_HZ)

    def observation(self, q: np.ndarray, dq: np.ndarray) -> np.ndarray:
        """(4 n + 1,) what a policy sees."""
        return np.concatenate([q, dq, self.via, self.goal, [float(self.passed)]])


@dataclass
class Trace:
    """Rows at `ROWS_HZ`, and observations and commands at `POLICY_HZ`."""

    q: list[np.ndarray] = field(default_factory=list)
    dq: list[np.ndarray] = field(default_factory=list)
    command: list[np.ndarray] = field(default_factory=list)
    observation: list[np.ndarray] = field(default_factory=list)


def attempted(
    attempt: Attempt,
    kp: np.ndarray,
    kd: np.ndarray,
    commander: Callable[[np.ndarray, np.ndarray], np.ndarray],
    rng: np.random.Generator,
) -> Trace:
    """Run it until success, its end, or until the arm runs away.

    Args:
        kp, kd: (n,) that the controller is told.
        commander: from what is observed and where the links are to the command, at `POLICY_HZ`.
        rng: of encoders' noise.
    """
    world = attempt.world
    machine = Machine(world.mjcf, world.joints, world.hidden, PHYSICS_HZ, True, attempt.start)
    control = world.control_rate_hz
    for effect in world.hidden:
        kp, kd = effect.gains(kp, kd)
        control = effect.control_rate_hz(control)
    per_tick, per_row, per_command = (
        round(PHYSICS_HZ / rate) for rate in (control, ROWS_HZ, POLICY_HZ)
    )
    late = round(sum(effect.delay_s for effect in world.hidden) * PHYSICS_HZ)

    def tick(command: np.ndarray) -> None:
        velocity, error = machine.dq, command - machine.q
        for effect in world.hidden:
            velocity = effect.seen_velocity(velocity, 1 / control)
        more = sum(effect.control(error, 1 / control) for effect in world.hidden)
        machine.tick(kp * error - kd * velocity + more)

    def measured() -> tuple[np.ndarray, np.ndarray]:
        q = machine.q + world.noise_rad * rng.normal(size=len(kp))
        dq = machine.dq + VELOCITY_NOISE_PER_S * world.noise_rad * rng.normal(size=len(kp))
        return np.round(q / world.step_rad) * world.step_rad, dq

    for step in range(round(REST_S * PHYSICS_HZ)):
        if step % per_tick == 0:
            tick(attempt.start)
        machine.step(clock_runs=False)
    trace = Trace()
    for k in range(attempt.ticks):
        q, dq = measured()
        trace.observation.append(attempt.observation(q, dq))
        trace.command.append(commander(trace.observation[-1], machine.q_link))
        for step in range(k * per_command, (k + 1) * per_command):
            if step % per_row == 0:
                for rows, values in zip((trace.q, trace.dq), measured(), strict=True):
                    rows.append(values)
            if step % per_tick == 0:
                at = (step - late) // per_command
                tick(trace.command[at] if at >= 0 else attempt.start)
            machine.step()
        link = machine.q_link
        if not np.abs(link - world.home).max() < LOST_RAD:
            break
        attempt.judge(link)
        if attempt.success:
            break
    return trace
