"""The position controller's PD law."""

import numpy as np
from numpy.typing import ArrayLike


def pd_torque(
    q_des: ArrayLike, q: ArrayLike, dq: ArrayLike, kp: ArrayLike, kd: ArrayLike
) -> np.ndarray:
    """τ = Kp (q_des − q) − Kd q̇, in N·m, for arrays that broadcast together.

    Args:
        q_des, q: rad.
        dq: rad/s.
        kp, kd: N·m/rad and N·m·s/rad.
    """
    q_des, q, dq = np.asarray(q_des), np.asarray(q), np.asarray(dq)
    return kp * (q_des - q) - kd * dq
