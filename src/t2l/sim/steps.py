"""Physics steps of second order under held torques, finer where dry friction turns.

MuJoCo's single-step integrators evaluate forces at q and advance to q + dt v'. Moving the position
dt/2 ahead before the steps and back after them evaluates forces at the middle of each step instead
(drift, kick, drift: leapfrog).

Where a joint turns within a step, MuJoCo takes its dry friction with one sign for all of it, or
stops the joint until the end. The velocity is then off by a share of what friction changes it by,
which no later step mends. So simulations of which a joint turns take finer steps at that tick.
"""

import mujoco.batch
import numpy as np
from mujoco.batch import Batch

from t2l.sim.dry_friction import stiffest

FINER = 8  # numerics: steps in place of one, at a tick at which dry friction turns
# numerics: of the velocity that friction takes away in a tick, that is rest beside it
REST = 0.01
NONE = np.zeros(0, int)


class Steps:
    """Steps of all simulations of a batch from plant tick to plant tick.

    Args:
        at_qpos, dofs: indices of the driven joints.
        nstep: physics steps each time.
        rubs: whether a joint may have dry friction.
    """

    def __init__(self, batch: Batch, at_qpos, dofs, nstep: int, rubs: bool):
        self.batch, self.at_qpos, self.dofs, self.nstep = batch, at_qpos, dofs, nstep
        self.dt = batch.model.opt.timestep
        # of what joints are faster in the steps, how far they are moved back before these
        self.before = 0.5 * (1 - 1 / nstep)
        self.half_step = 0.5 * self.dt * batch.qvel
        # fields of the batch that a finer step needs, as they are and as they are then
        self.finer: list[tuple[np.ndarray, np.ndarray, np.ndarray]] = []
        if rubs:
            names = ["opt.timestep", "dof_solref"]
            names += ["tendon_solref_fri"] if batch.model.ntendon else []
            for name in names:
                field = batch.expand(name)
                usual, fine = field.copy(), field.copy()
                if name == "opt.timestep":
                    fine /= FINER
                else:
                    hard = usual[..., 0] == stiffest(batch.model)
                    fine[..., 0] = np.where(hard, usual[..., 0] / FINER, usual[..., 0])
                self.finer.append((field, usual, fine))

    def go(
        self, running: np.ndarray | None, faster: np.ndarray, turning: np.ndarray | None
    ) -> np.ndarray:
        """Step; indices of the simulations in which MuJoCo failed.

        Args:
            running: (nsim,) bool, which simulations; None if all.
            faster: (nsim, njoint) by how much driven joints are faster meanwhile, rad/s; zero where
                one turns.
            turning: (nsim,) bool, in which a joint turns; None if in none.
        """
        qpos, qvel = self.batch.qpos, self.batch.qvel
        if turning is not None:
            self.half_step[turning] /= FINER
        qpos += self.half_step
        qvel[:, self.dofs] += faster
        # so far they go too far in these steps, half of it in the middle
        further = self.nstep * self.dt * faster
        qpos[:, self.at_qpos] -= self.before * further
        if turning is None:
            failed = self._step(running, self.nstep)
        else:
            others = ~turning if running is None else running & ~turning
            for field, _, fine in self.finer:
                field[turning] = fine[turning]
            some = ((others, self.nstep), (turning, self.nstep * FINER))
            failed = np.concatenate([self._step(ids, n) for ids, n in some])
            for field, usual, _ in self.finer:
                field[turning] = usual[turning]
        qvel[:, self.dofs] -= faster
        qpos[:, self.at_qpos] -= (1 - self.before) * further
        np.multiply(qvel, 0.5 * self.dt, out=self.half_step)
        if turning is None:
            qpos -= self.half_step
        else:
            qpos -= np.where(turning[:, None], self.half_step / FINER, self.half_step)
        return failed

    def _step(self, ids: np.ndarray | None, nstep: int) -> np.ndarray:
        if ids is None or ids.any():
            try:
                self.batch.step(ids=ids, nstep=nstep)
            except mujoco.batch.SimulationError as error:
                return error.ids
        return NONE


def turns(
    dq: np.ndarray, ddq: np.ndarray, period_s: float, taken: np.ndarray, running: np.ndarray
) -> np.ndarray | None:
    """Simulations (nsim,) in which a joint with dry friction turns within a period; None if none.

    Args:
        dq, ddq: (nsim, njoint) velocity, and acceleration if it goes on as before.
        taken: (nsim, njoint) velocity that friction takes away in a period.
    """
    turn = (dq * (dq + period_s * ddq) < 0) & (np.abs(dq) > REST * taken) & (taken > 0)
    turning = turn.any(axis=1) & running
    return turning if turning.any() else None
