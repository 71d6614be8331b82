"""Which few pairs of gains to train policies under, to settle what the predicted order leaves open.

The best of what is left by each of three orders: by prediction, by Kd/Kp, and by nearness to
critical damping, of which there is one at each stiffness and the middle one counts. Where one order
is wrong another may be right.
"""

from collections.abc import Sequence

import numpy as np

from t2l.gains import Cell

# format: of ln ζ, a factor of √2: a stiffness of the default grid has a damping so near to critical
NEAR_CRITICAL = np.log(2) / 2


def to_train(
    best: int, off_critical: np.ndarray, left: np.ndarray, cells: Sequence[Cell]
) -> list[int]:
    """Indices of cells, each once, the best by prediction first.

    Args:
        off_critical: (cell,) |ln ζ| of the joint of median inertia.
        left: (cell,) bool, which may be named.
    """
    kp, kd = np.array([[cell.kp, cell.kd] for cell in cells]).T
    damped = int(np.where(left, kd / kp, -np.inf).argmax())
    return list(dict.fromkeys((best, damped, middle(off_critical, left, kp))))


def middle(off_critical: np.ndarray, left: np.ndarray, kp: np.ndarray) -> int:
    """Of the cells that are left and near to critical damping, that of middle stiffness (cell,)."""
    near = np.flatnonzero(left & (off_critical <= off_critical[left].min() + NEAR_CRITICAL))
    return int(near[np.argsort(kp[near], kind="stable")[(len(near) - 1) // 2]])
