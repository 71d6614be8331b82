"""How stiff a tool is: K_eff = |F| / |Δx|, by constant forces (the study's appendix A-B).

Robots that begin alike are pushed in opposite directions. Δx is half of what lies between their
tools, on average over the second half of the push: what a policy does that does not answer the
force, such as a swing without end, is in both and cancels.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from t2l.robots.kinematics import ToolKinematics
from t2l.tasks.disturbance import Forces

if TYPE_CHECKING:
    from t2l.rl.environments import Environments

SETTLING_S = 1.0  # without a force, before it

# an observation (n, nobs) to an action (n, nact)
Act = Callable[[np.ndarray], np.ndarray]


@dataclass(frozen=True, eq=False)
class Probe:
    """Forces that a tool is held against.

    Attributes:
        force: (n, 3) N, in the world's frame.
        hold_s: how long each is held.
    """

    force: np.ndarray
    hold_s: float

    @property
    def duration_s(self) -> float:
        """Of a whole measurement, which ends before the episode does."""
        return SETTLING_S + self.hold_s


@dataclass(frozen=True, eq=False)
class Yielding:
    """What forces came to.

    Attributes:
        stiffness_n_m: (n,) K_eff.
        drift: (n,) how far the mean of either half of what is averaged is from Δx, over |Δx|: near
            0 where Δx is steady.
        swing: (n,) how far the tool swings about where it is on average, root mean square over time
            and both pushes, over |Δx|: near 0 where it rests.
    """

    stiffness_n_m: np.ndarray
    drift: np.ndarray
    swing: np.ndarray


class Constant(Forces):
    """Forces (n, 3) N that begin some time after the episode and stay."""

    def __init__(self, batch, force: np.ndarray, from_s: float):
        super().__init__(batch)
        self._constant, self._from_s = force, from_s

    def force(self, time_s):
        """See `Forces.force`."""
        return np.where((time_s >= self._from_s - 1e-9)[:, None], self._constant, 0.0)


def measure(environments: "Environments", act: Act, probe: Probe) -> Yielding:
    """Push robots that act by `act` from their goals on.

    Args:
        environments: two a force, with episodes longer than the probe.
    """
    task, n = environments.task, environments.num_envs
    rate_hz = 1 / environments.period_s
    force = np.concatenate([probe.force, -probe.force])
    environments.disturbance = Constant(environments.simulator.batch, force, SETTLING_S)
    home = task.sample_starts(environments.generator, n)
    observation = environments.place(home, task.sample_goals(environments.generator, n))
    steps = round(probe.duration_s * rate_hz)
    half = max(1, round(probe.hold_s / 4 * rate_hz))
    kinematics = ToolKinematics(task.robot, n)
    tool = []
    for step in range(steps):
        observation, *_ = environments.step(act(observation))
        if step >= steps - 2 * half:
            tool.append(kinematics.pose(environments.simulator.q)[:, :3])
    # half of the averaged time, instant, direction, force, xyz
    tool = np.stack(tool).reshape(2, half, 2, -1, 3)
    of_halves = (tool[:, :, 0] - tool[:, :, 1]).mean(axis=1) / 2
    away = of_halves.mean(axis=0)
    # the square root of it stays finite, whatever a policy does
    moved = np.maximum(np.linalg.norm(away, axis=1), np.sqrt(np.finfo(float).tiny))
    swings = ((tool - tool.mean(axis=(0, 1))) ** 2).sum(axis=-1).mean(axis=(0, 1, 2))
    return Yielding(
        np.linalg.norm(probe.force, axis=1) / moved,
        np.linalg.norm(of_halves - away, axis=2).max(axis=0) / moved,
        np.sqrt(swings) / moved,
    )
