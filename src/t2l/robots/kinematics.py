"""Where the tools of a robot are."""

import mujoco
import numpy as np

from t2l.robots.robot import Robot
from t2l.sim.batch import make_batch


class ToolKinematics:
    """Forward kinematics of `n` robots at a time, to the tool of their first group."""

    def __init__(self, robot: Robot, n: int):
        self._batch = make_batch(robot.spec().compile(), n)
        model = self._batch.model
        self._address = [model.joint(name).qposadr[0] for name in robot.joints]
        self._site = model.site(robot.groups[0].tool_site).id
        self._qpos = self._batch.qpos
        self._position = self._batch.bind("site_xpos")
        self._rotation = self._batch.bind("site_xmat")

    def pose(self, q: np.ndarray) -> np.ndarray:
        """(n, 12) in the base's frame at q (n, njoint) rad: position in m, rotation by rows."""
        self._qpos[:, self._address] = q
        self._batch.forward(stage=mujoco.mjtStage.mjSTAGE_POS.value)
        return site_pose(self._position, self._rotation, self._site)


def site_pose(position: np.ndarray, rotation: np.ndarray, site: int) -> np.ndarray:
    """(n, 12) from a batch's site_xpos and site_xmat."""
    return np.concatenate([position[:, site], rotation[:, site].reshape(len(position), 9)], axis=1)
