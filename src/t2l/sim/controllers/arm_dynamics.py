"""One arm's part of the dynamics of a batch."""

import mujoco
import numpy as np
from mujoco.batch import Batch

from t2l.sim.controllers.controller import Arm

# what it reads of a step
FIELDS = ("M", "qfrc_bias", "qfrc_gravcomp", "site_xpos", "site_xmat", "cdof", "subtree_com")


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
        self._root = model.body_rootid[self._site.bodyid[0]]
        for field in FIELDS:
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
        """(nsim, 6, njoint), translation above rotation, world frame.

        As `mj_jac`, from what a step leaves; that would compute where bodies are once more.
        """
        x, y, z, *moved = self._batch.cdof[:, self._dofs].transpose(2, 1, 0).copy()
        a, b, c = (self.position - self._batch.subtree_com[:, self._root]).T.copy()
        # the velocity there of a turn about each axis: axis × offset
        turned = y * c - z * b, z * a - x * c, x * b - y * a
        linear = [one + other for one, other in zip(moved, turned, strict=True)]
        return np.stack([*linear, x, y, z]).transpose(2, 0, 1).copy()

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
