"""Which pairs of gains are looked at: a grid over the natural frequencies that robots use."""

from collections.abc import Iterable

import numpy as np

from t2l.gains import Grid

# convention: of the mean joint, natural frequencies by half octaves; about the study's grid of an
# FR3: slower does not keep up with a hand, faster is asked for by no task
FREQUENCIES_HZ = 1.25 * 2.0 ** (np.arange(7) / 2)
# convention: at the middle stiffness, from a joint that swings ten times to one that creeps
DAMPINGS = 2.0 ** np.arange(-4, 4)
FACTORS = 2.0 ** np.arange(-3, 4)  # convention: stiffness over as many octaves
DIGITS = 2  # format: of a gain that a person reads


def default_grid(inertia: np.ndarray) -> Grid:
    """Of a robot whose joints move inertias (k, n) kg·m² at k poses."""
    mean = np.exp(np.mean(np.log(inertia.mean(axis=0))))
    kp = mean * (2 * np.pi * FREQUENCIES_HZ) ** 2
    kd = 2 * np.sqrt(mean * kp[len(kp) // 2]) * DAMPINGS
    return of(map(rounded, kp), map(rounded, kd))


def grid_of_factors() -> Grid:
    """Of a robot that has gains of its own, which those of a cell are factors on."""
    return of(FACTORS, DAMPINGS)


def of(kp: Iterable[float], kd: Iterable[float]) -> Grid:
    """A grid of these gains, split in the middle."""
    kp, kd = tuple(sorted(map(float, kp))), tuple(sorted(map(float, kd)))
    return Grid(kp, kd, kp[(len(kp) - 1) // 2], kd[len(kd) // 2])


def rounded(gain: float) -> float:
    """To `DIGITS` digits."""
    return float(f"{gain:.{DIGITS}g}")
