"""What a study of transfer needs to decide: known before it runs."""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Rule:
    """The section `transfer_decision` of a configuration; see there."""

    condition: str
    alpha: float
    stiff_from_kp: float
    overdamped_from_kd: float
    cells: int
    seeds: int
    success: float

    def inside(self, kp: np.ndarray, kd: np.ndarray) -> np.ndarray:
        """(n,) bool, which gains are in G^SO."""
        return (np.asarray(kp) >= self.stiff_from_kp) & (np.asarray(kd) >= self.overdamped_from_kd)
