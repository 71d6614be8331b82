"""How well the predicted order of gains was right where policies were trained: evidence.yaml.

`python -m benchmarks advice` measures and writes it; nobody edits it.
"""

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from functools import cache
from importlib.resources import files
from pathlib import Path

import numpy as np

from t2l.artefacts import write_text
from t2l.documents import read_yaml, to_yaml

EVIDENCE = "evidence.yaml"
OURS, STUDY = "ours", "the study's"


@dataclass(frozen=True)
class Measured:
    """One grid of cells with trained policies.

    Attributes:
        grid: the task; whose: `OURS`, where the order was fitted on the other tasks alone, or
            `STUDY`, of which nothing was fitted.
        cells: how many were ranked.
        rho: Spearman's, of the predicted order with success.
        rho_ratio, rho_critical, rho_compliant: of Kd/Kp, of nearness to critical damping, and of
            the compliant and overdamped region.
        best, advised, ratio, critical: success of the best cell, of the cell that is predicted to
            be best, of that with the largest Kd/Kp, and mean of those nearest critical damping at
            each stiffness.
    """

    grid: str
    whose: str
    cells: int
    rho: float
    rho_ratio: float
    rho_critical: float
    rho_compliant: float
    best: float
    advised: float
    ratio: float
    critical: float

    @property
    def lost(self) -> float:
        """By how much the advised cell's success is below the best cell's."""
        return self.best - self.advised


@cache
def evidence() -> tuple[Measured, ...]:
    """What is kept in the package."""
    kept = Path(str(files("t2l.advise") / EVIDENCE))
    return tuple(Measured(**row) for row in read_yaml(kept, "measured orders"))


def write_evidence(rows: Sequence[Measured], path: Path) -> None:
    """Write what was measured, with as many digits as it is worth."""
    plain = [
        {key: round(value, 3) if isinstance(value, float) else value for key, value in row.items()}
        for row in map(asdict, rows)
    ]
    write_text(to_yaml(plain, sort_keys=False), path)


def mean_rho(rows: Sequence[Measured], key: str = "rho") -> float:
    """Over grids, each of which counts as one."""
    return float(np.mean([getattr(row, key) for row in rows]))
