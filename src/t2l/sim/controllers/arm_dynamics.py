"""One arm's part of the dynamics of a batch."""

import mujoco
import numpy as np
from mujoco.batch import Batch

from t2l.sim.controllers.controller import Arm


class ArmDynamics:
    """Pose and Jacobian of an arm's tool, its inertia and its bias torques.

    Make it before the batch's first step, so that every step refreshes what it reads.
    """

    def __init__(self, batch: Batch, arm: Arm):
        self._batch, model = batch, batch.model
        self._site = model.site(arm.tool_site)
        self._qpos = np.array([model.joint(name).qposadr[0] for name in arm.joints])
        self._dofs = dofs = np.array([model.joint(name).dofadr[0] for name in arm.joints])
        rows = np.repeat(np.arange(model.nv), model.M_rownnz)
        own = np.isin(rows, dofs) & np.isin(model.M_colind, dofs)
        order = np.argsort(dofs)
        self._entries = np.flatnonzero(own)
        self._rows = order[np.searchsorted(dofs, rows[own], sorter=order)]
        self._columns = order[np.searchsorted(dofs, model.M_colind[own], sorter=order)]
        for field in ("M", "qfrc_bias", "qfrc_gravcomp", "site_xpos", "site_xmat"):
            batch.bind(field)
        batch.forward(stage=mujoco.mjtStage.mjSTAGE_VEL.value)

    @property
    def q(self) -> np.ndarray:
        """(nsim, njoint) rad."""
        return self._batch.qpos[:, self._qpos]

    @property
    def dq(self) -> np.ndarray:
        """(nsim, njoint) rad/s."""
        return self._batch.qvel[:, self._dofs]

    @property
    def position(self) -> np.ndarray:
        """(nsim, 3) of the tool, m, world."""
        return self._batch.site_xpos[:, self._site.id]

    @property
    def rotation(self) -> np.ndarray:
        """(nsim, 3, 3) of the tool, world."""
        return self._batch.site_xmat[:, self._site.id].reshape(-1, 3, 3)

    def jacobian(self) -> np.ndarray:
        """(nsim, 6, njoint), translation above rotation, world frame."""
        linear, angular = self._batch.jac(int(self._site.bodyid[0]), self.position)
        return np.concatenate([linear, angular], axis=1)[:, :, self._dofs]

    def mass(self) -> np.ndarray:
        """(nsim, njoint, njoint) joint-space inertia."""
        values = self._batch.M[:, self._entries]
        mass = np.zeros((self._batch.nsim, self._dofs.size, self._dofs.size))
        mass[:, self._rows, self._columns] = values
        mass[:, self._columns, self._rows] = values
        return mass

    def bias(self) -> np.ndarray:
        """(nsim, njoint) Coriolis torque and whatever gravity is not compensated, N·m."""
        return (self._batch.qfrc_bias - self._batch.qfrc_gravcomp)[:, self._dofs]
