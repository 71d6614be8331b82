"""The course of a motion from rest to rest that jerks least."""

import numpy as np

# of the path, at its middle
PEAK_SPEED = 1.875


def minimum_jerk(s: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Path, speed and acceleration at s in [0, 1] (Flash and Hogan 1985, eq. B.1)."""
    path = s**3 * (10 - 15 * s + 6 * s**2)
    speed = 30 * s**2 * (1 - s) ** 2
    acceleration = 60 * s * (1 - s) * (1 - 2 * s)
    return path, speed, acceleration
