"""Operational-space control: joint torques that move a grip frame like a damped spring.

Khatib (1987), "A unified approach for motion and force control of robot manipulators", eq. 31-35,
for a batch of states.
"""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class OperationalSpaceGains:
    """Closed-loop stiffness in 1/s²; damping is critical. Posture acts in the null space only."""

    position: float = 900.0
    rotation: float = 900.0
    posture: float = 60.0


def rotation_error(rotation_des: np.ndarray, rotation: np.ndarray) -> np.ndarray:
    """World-frame axis-angle error between (n, 3, 3) rotations, (n, 3), exact to first order.

    Half the sum of the cross products of the columns (Luh, Walker and Paul 1980, eq. 18).
    """
    return 0.5 * np.cross(rotation, rotation_des, axisa=1, axisb=1, axisc=2).sum(axis=1)


def operational_space_torque(
    q: np.ndarray,
    dq: np.ndarray,
    mass: np.ndarray,
    jacobian: np.ndarray,
    bias: np.ndarray,
    position_error: np.ndarray,
    rotation_error: np.ndarray,
    twist_des: np.ndarray,
    acceleration_des: np.ndarray,
    posture: np.ndarray,
    gains: OperationalSpaceGains,
) -> np.ndarray:
    """Torques, (n, dof) N·m.

    Args:
        q, dq: (n, dof) rad and rad/s.
        mass: (n, dof, dof) joint-space inertia, kg·m².
        jacobian: (n, 6, dof), translation above rotation, world frame.
        bias: (n, dof) Coriolis torque and whatever gravity nothing else compensates, N·m.
        position_error, rotation_error: (n, 3) desired minus actual, m and rad.
        twist_des, acceleration_des: (n, 6) desired velocity and acceleration of the frame.
        posture: (dof,) rad, the pose that the null space drifts to.
    """
    stiffness = np.repeat([gains.position, gains.rotation], 3)
    error = np.concatenate([position_error, rotation_error], axis=1)
    twist = np.einsum("nij,nj->ni", jacobian, dq)
    acceleration = (
        acceleration_des + stiffness * error + 2 * np.sqrt(stiffness) * (twist_des - twist)
    )
    mass_inverse = np.linalg.inv(mass)
    mobility = jacobian @ mass_inverse @ jacobian.transpose(0, 2, 1)
    # damped least squares keeps torques bounded near a singular pose
    inertia = np.linalg.inv(mobility + 1e-4 * np.eye(6))
    wrench = np.einsum("nij,nj->ni", inertia, acceleration)

    inverse_jacobian = mass_inverse @ jacobian.transpose(0, 2, 1) @ inertia
    null = np.eye(q.shape[1]) - jacobian.transpose(0, 2, 1) @ inverse_jacobian.transpose(0, 2, 1)
    drift = gains.posture * (posture - q) - 2 * np.sqrt(gains.posture) * dq
    posture_torque = np.einsum("nij,nj->ni", mass, drift)
    return (
        np.einsum("nji,nj->ni", jacobian, wrench)
        + np.einsum("nij,nj->ni", null, posture_torque)
        + bias
    )
