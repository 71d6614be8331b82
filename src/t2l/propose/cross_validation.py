"""What a fit foretells of data that were left out of it, without a fit for each part left out."""

import numpy as np

LEAST = 1e-10  # numerics: of the normal equations: keeps what no data touch at zero


def left_out(jacobian: np.ndarray, residual: np.ndarray, block: np.ndarray) -> np.ndarray:
    """(n,) residuals of each block where all other blocks alone are fitted.

    Exact for a model that is linear in its parameters: one step of Gauss and Newton leads from the
    fit of all blocks to that of the others.

    Args:
        jacobian: (n, k) of the residuals, where all blocks were fitted.
        residual: (n,) there.
        block: (n,) whole numbers.
    """
    unit = jacobian / np.maximum(np.linalg.norm(jacobian, axis=0), np.finfo(float).tiny)
    normal, right = unit.T @ unit, unit.T @ residual
    left = np.empty(len(residual))
    for number in np.unique(block):
        at = block == number
        rest = normal - unit[at].T @ unit[at]
        step = np.linalg.solve(rest + LEAST * np.eye(len(rest)), right - unit[at].T @ residual[at])
        left[at] = residual[at] - unit[at] @ step
    return left
