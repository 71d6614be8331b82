"""One recorded demonstration."""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Demonstration:
    """What a torque-controlled run recorded at every timestep, before that step.

    Attributes:
        qpos: (n, nq) positions of everything in the scene.
        dq: (n, dof) rad/s, arm.
        torque: (n, dof) N·m, commanded by the expert, net of the robot's own gravity compensation.
        gripper: (n,) m, commanded finger position.
    """

    qpos: np.ndarray
    dq: np.ndarray
    torque: np.ndarray
    gripper: np.ndarray

    def __len__(self) -> int:
        return len(self.gripper)
