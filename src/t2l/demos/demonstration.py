"""One recorded demonstration."""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Demonstration:
    """What a torque-controlled run recorded at every timestep, before that step.

    Attributes:
        qpos: (n, nq) positions of everything in the scene.
        dq: (n, njoint) rad/s, of the robot's joints.
        torque: (n, njoint) N·m, by the expert, net of the robot's own gravity compensation.
        gripper: (n, ngripper) commanded, in the unit of each gripper.
    """

    qpos: np.ndarray
    dq: np.ndarray
    torque: np.ndarray
    gripper: np.ndarray

    def __len__(self) -> int:
        return len(self.gripper)
