"""How stiff a tool is: K_eff = |F| / |Δx|, by constant forces (the study's appendix A-B)."""

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
        drift: (n,) how far the tool moved in the last `AVERAGED_S`, over |Δx|: near 0 where it had
            come to rest.
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
    """Push every robot of `environments`, which acts by `act`, from its goal on.

    Δx is between the tool's place just before the force and its mean place at the end of it.

    Args:
        environments: as many as there are forces, with episodes longer than the probe.
    """
    task, n = environments.task, environments.num_envs
    batch, rate_hz = environments.simulator.batch, 1 / environments.period_s
    environments.disturbance = Constant(batch, probe.force, SETTLING_S)
    home = task.sample_starts(environments.generator, n)
    observation = environments.place(home, task.sample_goals(environments.generator, n))
    steps, settled = (round(s * rate_hz) for s in (probe.duration_s, SETTLING_S))
    q = np.empty((steps, *home.shape))
    for step in range(steps):
        observation, *_ = environments.step(act(observation))
        q[step] = environments.simulator.qpos
    averaged = max(1, round(min(AVERAGED_S, probe.hold_s / 2) * rate_hz))
    kinematics = ToolKinematics(task.robot, n)
    before = kinematics.pose(q[settled - 1])[:, :3]
    late = np.stack([kinematics.pose(q[-i])[:, :3] for i in range(averaged, 0, -1)])
    moved = np.linalg.norm(late.mean(axis=0) - before, axis=1)
    moved = np.maximum(moved, np.finfo(float).tiny)
    size = np.linalg.norm(probe.force, axis=1)
    return Yielding(size / moved, np.linalg.norm(late[-1] - late[0], axis=1) / moved)
