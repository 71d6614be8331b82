"""Physics steps of second order under held torques.

MuJoCo's single-step integrators evaluate forces at q and advance to q + dt v'. Moving the position
dt/2 ahead before the steps and back after them evaluates forces at the middle of each step instead
(drift, kick, drift: leapfrog).
"""

import mujoco.batch
import numpy as np
from mujoco.batch import Batch

NONE = np.zeros(0, int)


class Steps:
    """Steps of all simulations of a batch from plant tick to plant tick.

    Args:
        at_qpos, dofs: indices of the driven joints.
        nstep: physics steps each time.
    """

    def __init__(self, batch: Batch, at_qpos, dofs, nstep: int):
        self.batch, self.at_qpos, self.dofs, self.nstep = batch, at_qpos, dofs, nstep
        self.dt = batch.model.opt.timestep
        # of what joints are faster in the steps, how far they are moved back before these
        self.before = 0.5 * (1 - 1 / nstep)
        self.half_step = 0.5 * self.dt * batch.qvel

    def go(self, running: np.ndarray | None, faster: np.ndarray) -> np.ndarray:
        """Step; indices of the simulations in which MuJoCo failed.

        Args:
            running: (nsim,) bool, which simulations; None if all.
            faster: (nsim, njoint) by how much driven joints are faster meanwhile, rad/s.
        """
        qpos, qvel, failed = self.batch.qpos, self.batch.qvel, NONE
        qpos += self.half_step
        qvel[:, self.dofs] += faster
        # so far they go too far in these steps, half of it in the middle
        further = self.nstep * self.dt * faster
        qpos[:, self.at_qpos] -= self.before * further
        try:
            self.batch.step(ids=running, nstep=self.nstep)
        except mujoco.batch.SimulationError as error:
            failed = error.ids
        qvel[:, self.dofs] -= faster
        qpos[:, self.at_qpos] -= (1 - self.before) * further
        np.multiply(qvel, 0.5 * self.dt, out=self.half_step)
        qpos -= self.half_step
        return failed
