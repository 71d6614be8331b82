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
ALIKE = 1.25  # measured: up to this factor, three pairs in five are in the right order
OURS, OTHER, STUDY = "ours", "ours, UR5e", "the study's"


@dataclass(frozen=True)
class Measured:
    """One grid of cells with trained policies.

    Attributes:
        grid: the task; whose: `OURS`, where the order was fitted on the other tasks alone, or of
            which nothing was fitted: `OTHER`, another robot of ours, or `STUDY`.
        cells: how many were ranked.
        rho: Spearman's, of the predicted order with success.
        rho_ratio, rho_critical, rho_compliant: of Kd/Kp, of nearness to critical damping, and of
            the compliant and overdamped region.
        best, advised, ratio, critical: success of the best cell, of the cell that is predicted to
            be best, of that with the largest Kd/Kp, and mean of those nearest critical damping at
            each stiffness.
        ringing: how many cells are ruled out as they ring; in_them, in_others: mean success.
        best_rings: whether the best cell is one of them; advised_left: success of the cell that is
            predicted to be best of the others.
        trained: that of the best of the three of the others that `t2l.advise.trainings` names;
            trained_at_random: the same of as many of the others, on average.
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
    ringing: int
    in_them: float
    in_others: float
    best_rings: bool
    advised_left: float
    trained: float
    trained_at_random: float

    @property
    def lost(self) -> float:
        """By how much the advised cell's success is below the best cell's."""
        return self.best - self.advised


@dataclass(frozen=True)
class Pairs:
    """How often, of two cells, the one of the smaller predicted error succeeded more.

    Attributes:
        factor: from this one of their predicted errors on, up to that of the next entry.
        right: share of pairs, ties counting half; the mean over grids, ours and the study's.
        least: that of the grid where it is least.
    """

    factor: float
    right: float
    least: float


@dataclass(frozen=True)
class Trials:
    """Trainings by reinforcement of Joint-Reach whose action scales lay in the range, and others.

    Attributes:
        seconds: of the motions that the range is of: smooth ones from start to goal.
        inside, outside: how many; inside_succeeded, outside_succeeded: share of them that reached
            a success of 0.95.
    """

    seconds: float
    inside: int
    inside_succeeded: float
    outside: int
    outside_succeeded: float


@dataclass(frozen=True)
class Settling:
    """What is lost against the best cell, share of success, mean over the grids of ours.

    Attributes:
        trainings: policies that were trained.
        lost: if they are those that `t2l advise --train` chooses, what it has fitted being fitted
            without the grid at hand; at_random: if they are of cells at random.
    """

    trainings: int
    lost: float
    at_random: float


@dataclass(frozen=True)
class Planted:
    """Worlds with hidden effects whose policies were trained; see `benchmarks.planted.verdict`.

    Attributes:
        half: `development` or `test`.
        known: `nominal` or `explained`, what the advice was given of the machine.
        worlds: how many.
        within: of them, those where the cell that is named succeeds at most 5 per cent points less
            than the best; lost: how much less on average, which may be below zero.
        critical_within, critical_lost: of critical damping at 5 Hz; ratio_within, ratio_lost: of
            the largest Kd/Kp.
        ruled_out, failed: cells that are ruled out, and those of them that fail.
        best_ruled_out: worlds whose best cell is ruled out.
    """

    half: str
    known: str
    worlds: int
    within: int
    lost: float
    critical_within: int
    critical_lost: float
    ratio_within: int
    ratio_lost: float
    ruled_out: int
    failed: int
    best_ruled_out: int


@dataclass(frozen=True)
class Evidence:
    """All that was measured.

    Attributes:
        grids: one a grid.
        trials: by seconds.
        pairs: by rising factor, of which the first is 1.
        settling: by rising number of trainings, from none.
        planted: one a half and what is known.
    """

    grids: tuple[Measured, ...]
    pairs: tuple[Pairs, ...]
    trials: tuple[Trials, ...]
    settling: tuple[Settling, ...]
    planted: tuple[Planted, ...]

    def in_worlds(self, known: str) -> Planted:
        """Of the worlds that nothing was fitted to."""
        return next(row for row in self.planted if (row.half, row.known) == ("test", known))

    def of(self, whose: str) -> tuple[Measured, ...]:
        """The grids of `OURS` or `STUDY`."""
        return tuple(row for row in self.grids if row.whose == whose)

    def right(self, factor: float) -> Pairs:
        """Of pairs whose predicted errors differ by a factor of 1 or more."""
        return [one for one in self.pairs if one.factor <= factor][-1]


@cache
def evidence() -> Evidence:
    """What is kept in the package."""
    kept = read_yaml(Path(str(files("t2l.advise") / EVIDENCE)), "measured orders")
    return Evidence(
        tuple(Measured(**row) for row in kept["grids"]),
        tuple(Pairs(**row) for row in kept["pairs"]),
        tuple(Trials(**row) for row in kept["trials"]),
        tuple(Settling(**row) for row in kept["settling"]),
        tuple(Planted(**row) for row in kept["planted"]),
    )


def write_evidence(found: Evidence, path: Path) -> None:
    """Write what was measured, with as many digits as it is worth."""

    def plain(row: Measured | Pairs | Trials | Settling | Planted) -> dict:
        values = asdict(row).items()
        return {
            key: round(value, 4) if isinstance(value, float) else value for key, value in values
        }

    content = {key: [*map(plain, getattr(found, key))] for key in vars(found)}
    write_text(to_yaml(content, sort_keys=False), path)


def mean_of(rows: Sequence[Measured], key: str) -> float:
    """Over grids, each of which counts as one."""
    return float(np.mean([getattr(row, key) for row in rows]))
