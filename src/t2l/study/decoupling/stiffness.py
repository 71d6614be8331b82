"""How stiff a tool is: K_eff = |F| / |Δx|, by constant forces (the study's appendix A-B).

Δx is how far the tool is from that of a twin which no force pushes: a policy that does not come to
rest is not taken for one that yields.
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
AVERAGED_S = 0.5  # at the end of the force: what is left of an oscillation averages out

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
        drift: (n,) how much Δx changed in the last `AVERAGED_S`, over its mean there: near 0 where
            the tool had come to rest.
    """

    stiffness_n_m: np.ndarray
    drift: np.ndarray


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
        environments: one a force, and one for the twin, with episodes longer than the probe.
    """
    task, n = environments.task, environments.num_envs
    rate_hz = 1 / environments.period_s
    force = np.concatenate([probe.force, np.zeros((1, 3))])
    environments.disturbance = Constant(environments.simulator.batch, force, SETTLING_S)
    home = task.sample_starts(environments.generator, n)
    observation = environments.place(home, task.sample_goals(environments.generator, n))
    steps = round(probe.duration_s * rate_hz)
    averaged = max(2, round(min(AVERAGED_S, probe.hold_s / 2) * rate_hz))
    kinematics = ToolKinematics(task.robot, n)
    tool = []
    for step in range(steps):
        observation, *_ = environments.step(act(observation))
        if step >= steps - averaged:
            tool.append(kinematics.pose(environments.simulator.q)[:, :3])
    away = np.stack(tool)
    away = away[:, :-1] - away[:, -1:]
    moved = np.linalg.norm(away.mean(axis=0), axis=1)
    # the square root of it stays finite, whatever a policy does
    moved = np.maximum(moved, np.sqrt(np.finfo(float).tiny))
    size = np.linalg.norm(probe.force, axis=1)
    return Yielding(size / moved, np.linalg.norm(away[-1] - away[0], axis=1) / moved)
