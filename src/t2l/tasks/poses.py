"""Poses of free bodies, position in m above a quaternion, w first; and turns of quaternions."""

import numpy as np

from t2l.sim.arrays import Array, like, namespace


def upright(position: np.ndarray, yaw: np.ndarray) -> np.ndarray:
    """(n, 7) poses at `position` (n, 3), turned by `yaw` (n,) rad about the vertical."""
    return tilted(position, yaw, np.zeros(len(yaw)))


def tilted(position: np.ndarray, yaw: np.ndarray, tilt: np.ndarray) -> np.ndarray:
    """As `upright`, but turned by `tilt` (n,) rad about their own x before."""
    cy, sy, ct, st = np.cos(yaw / 2), np.sin(yaw / 2), np.cos(tilt / 2), np.sin(tilt / 2)
    turn = np.stack([cy * ct, cy * st, sy * st, sy * ct], axis=1)
    return np.concatenate([position, turn], axis=1)


def position_and_axes(pose: Array) -> Array:
    """(n, 9): position and the first two columns of the rotation of (n, 7) poses."""
    xp, (w, x, y, z) = namespace(pose), (pose[:, i] for i in range(3, 7))
    first = 1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)
    second = 2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x)
    return xp.concat([pose[:, :3], xp.stack([*first, *second], axis=1)], axis=1)


def rotation_rows(quaternion: Array) -> tuple[Array, Array, Array]:
    """Rows (n, 3) of the rotation of (n, 4) quaternions, w first."""
    xp, (w, x, y, z) = namespace(quaternion), (quaternion[:, i] for i in range(4))
    return (
        xp.stack([1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)], axis=1),
        xp.stack([2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)], axis=1),
        xp.stack([2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)], axis=1),
    )


def into_frame(rows: tuple[Array, Array, Array], vector: Array) -> Array:
    """(n, 3) vectors of the world in the frame whose rotation has these rows."""
    return sum(row * vector[:, i, None] for i, row in enumerate(rows))


def product(one: Array, other: Array) -> Array:
    """Of quaternions (n, 4), w first."""
    xp = namespace(one)
    a, b, c, d = (one[:, i] for i in range(4))
    w, x, y, z = (other[:, i] for i in range(4))
    return xp.stack(
        [
            a * w - b * x - c * y - d * z, a * x + b * w + c * z - d * y,
            a * y - b * z + c * w + d * x, a * z + b * y - c * x + d * w,
        ],
        axis=1,
    )  # fmt: skip


def conjugate(quaternion: Array) -> Array:
    """The turn back."""
    return quaternion * like(np.array([1.0, -1.0, -1.0, -1.0]), quaternion)


def about(axis: int, angle: np.ndarray) -> np.ndarray:
    """(n, 4) quaternions of turns by (n,) rad about x, y or z."""
    turn = np.zeros((len(angle), 4))
    turn[:, 0], turn[:, 1 + axis] = np.cos(angle / 2), np.sin(angle / 2)
    return turn
