"""Rotation vectors of many rotation matrices, without a check of each that they are rotations."""

import numpy as np


def rotation_vectors(matrices: np.ndarray) -> np.ndarray:
    """(n, 3) rad of rotations (n, 3, 3), at most half a turn; NaN stays NaN.

    By the quaternion (x, y, z, w): of four times its outer product with itself the row of its
    largest element, which is never small (Shepperd 1978, "Quaternion from rotation matrix").
    """
    a, b, c, d, e, f, g, h, i = matrices.reshape(-1, 9).T.copy()
    products = np.empty((4, 4, len(matrices)))
    products[0] = 1 + a - e - i, b + d, c + g, h - f
    products[1] = b + d, 1 - a + e - i, f + h, c - g
    products[2] = c + g, f + h, 1 - a - e + i, d - b
    products[3] = h - f, c - g, d - b, 1 + a + e + i
    largest = products[range(4), range(4)].argmax(axis=0)
    x, y, z, w = products[largest, :, np.arange(len(matrices))].T
    size = np.sqrt(x * x + y * y + z * z)
    # half the angle, whichever of the two quaternions of a rotation it is
    half = np.arctan2(size, abs(w))
    # its limit for no turn is 2 / w, and w is 4 then
    share = np.divide(2 * half, size, out=np.full(len(size), 0.5), where=size > 0)
    return (np.copysign(share, w) * np.stack([x, y, z])).T
