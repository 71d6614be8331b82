"""Where the flange is."""

import mujoco
import numpy as np

from t2l.identify.training_simulator import model
from t2l.robots.fr3 import JOINTS
from t2l.sim.batch import make_batch

SITE = "attachment_site"


class Flange:
    """Forward kinematics of `n` arms at a time."""

    def __init__(self, n: int):
        self._batch = make_batch(model(), n)
        self._site = self._batch.model.site(SITE).id
        self._qpos = self._batch.qpos
        self._position, self._rotation = (
            self._batch.bind("site_xpos"),
            self._batch.bind("site_xmat"),
        )

    def pose(self, q: np.ndarray) -> np.ndarray:
        """(n, 12) in the base frame at q (n, 7) rad: position in m, rotation matrix by rows."""
        self._qpos[:] = np.broadcast_to(q, (len(self._qpos), len(JOINTS)))
        self._batch.forward(stage=mujoco.mjtStage.mjSTAGE_POS.value)
        return flange_pose(self._position, self._rotation, self._site)


def flange_pose(position: np.ndarray, rotation: np.ndarray, site: int) -> np.ndarray:
    """(n, 12) from a batch's site_xpos and site_xmat."""
    return np.concatenate([position[:, site], rotation[:, site].reshape(len(position), 9)], axis=1)
