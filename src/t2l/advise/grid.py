"""Which pairs of gains are looked at: a grid over the natural frequencies that robots use."""

import numpy as np

from t2l.gains import Grid

# convention: of the mean joint, natural frequencies by half octaves; about the study's grid of an
# FR3: slower does not keep up with a hand, faster is asked for by no task
FREQUENCIES_HZ = 1.25 * 2.0 ** (np.arange(7) / 2)
# convention: at the middle stiffness, from a joint that swings ten times to one that creeps
DAMPINGS = 2.0 ** np.arange(-4, 4)
DIGITS = 2  # format: of a gain that a person reads


def default_grid(inertia: np.ndarray, units: np.ndarray | None = None) -> Grid:
    """Of a robot whose joints move inertias (k, n) kg·m² at k poses.

    Args:
        units: (n, 2) what gains of a cell are factors on, if they are no gains of every joint.
    """
    each = inertia.mean(axis=0)
    mean = np.exp(np.mean(np.log(each)))
    kp = mean * (2 * np.pi * FREQUENCIES_HZ) ** 2
    kd = 2 * np.sqrt(mean * kp[len(kp) // 2]) * DAMPINGS
    if units is not None:
        kp, kd = (
            gain / np.exp(np.mean(np.log(unit)))
            for gain, unit in zip((kp, kd), units.T, strict=True)
        )
    return of(map(rounded, kp), map(rounded, kd))


def of(kp, kd) -> Grid:
    """A grid of these gains, split in the middle."""
    kp, kd = tuple(sorted(kp)), tuple(sorted(kd))
    return Grid(kp, kd, kp[(len(kp) - 1) // 2], kd[len(kd) // 2])


def rounded(gain: float) -> float:
    """To `DIGITS` digits."""
    return float(f"{gain:.{DIGITS}g}")
