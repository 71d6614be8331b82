"""Claims about noise on actions: the theorem, its corollary, replays under noise."""

from collections.abc import Callable

import numpy as np
import pandas as pd

from t2l.advise.attenuation import SMALL, attenuation, effective_error
from t2l.stats.bootstrap import mean
from t2l.stats.rank import spearman
from t2l.stats.verdict import Finding, above_zero, correlated, every_at_most, greater, within
from t2l.study.claim import Claim, Judge
from t2l.study.cloning.claims import (
    ANEW,
    CELLS,
    GRID,
    LOSS,
    NOMINAL,
    OR_COLLECTIONS,
    TASK,
    anew,
    cells_of,
    of_each,
)
from t2l.study.evidence import AbsentError, Evidence
from t2l.study.published.numbers import Published, splits
from t2l.study.words import among, percents

VARIANCE_COLUMNS = ("plant", "inertia_kg_m2", "kp", "kd", "hold_s", "noise_rad", "variance_rad2")


def _variances(evidence: Evidence) -> pd.DataFrame:
    """Simulated variances with the theorem's: σ² h Kp / (2 Kd), h the time an error is held."""
    table = evidence.table("variance", VARIANCE_COLUMNS)
    held = attenuation(table.kp, table.kd, table.hold_s)
    table = table.assign(ratio=table.variance_rad2 / (table.noise_rad**2 * held))
    # where an error is held for long beside the motion that it causes, white noise is no model
    short = table[held < SMALL]
    if short.empty:
        raise AbsentError("no cell in which the hold is short")
    return short


def _theorem(evidence: Evidence, published: Published, tests: int) -> Finding:
    table = _variances(evidence)
    found = every_at_most(np.abs(table.ratio - 1), published.values["error"])
    return among(found, "wrong by at most {:.1%}", [found.value])


def _mass(evidence: Evidence, published: Published, tests: int) -> Finding:
    groups = _variances(evidence).groupby(["kp", "kd", "hold_s"]).ratio
    spread = (groups.max() / groups.min() - 1)[groups.size() > 1]
    if spread.empty:
        raise AbsentError("one inertia only")
    found = every_at_most(spread.to_numpy(), published.values["spread"])
    return among(found, "differs by at most {:.1%}", [found.value])


def with_errors(cells: pd.DataFrame) -> pd.DataFrame:
    """Cells with their RMS validation error and the corollary's effective error."""
    # as if held for a second: ranks are the same for every hold
    effective = effective_error(cells.kp, cells.kd, cells[LOSS], hold_s=1.0)
    return cells.assign(error=np.sqrt(cells[LOSS]), effective=effective)


def _anew(evidence: Evidence) -> pd.DataFrame | None:
    """The same of each collection, where there are enough of them."""
    own = anew(evidence, NOMINAL, TASK, LOSS)
    return None if own is None else with_errors(own)


def _effective(evidence: Evidence, published: Published, tests: int) -> Finding:
    if (own := _anew(evidence)) is not None:
        return of_each(own, lambda cells: spearman(cells.effective, cells.success), -1, tests)
    cells = with_errors(cells_of(evidence, NOMINAL, TASK, LOSS))
    x, y = cells.effective, cells.success
    return correlated(x, y, -1, tests=tests, claimed=published.effect)


def stronger(effective: np.ndarray, rival: np.ndarray, success: np.ndarray) -> np.ndarray:
    """By how much success falls with the effective error more than it goes with a rival.

    ρ of the effective error counts with the claimed sign, ρ of the rival whatever its own is: what
    rises with success tells it as well as what falls.
    """
    return -spearman(effective, success) - np.abs(spearman(rival, success))


def _beats(rival: Callable[[pd.DataFrame], pd.Series]) -> Judge:
    def columns(cells: pd.DataFrame) -> list[np.ndarray]:
        known = (cells.effective, rival(cells), cells.success)
        return [column.to_numpy(float) for column in known]

    def judge(evidence: Evidence, published: Published, tests: int) -> Finding:
        if (own := _anew(evidence)) is not None:
            found = of_each(own, lambda cells: stronger(*columns(cells)), +1, tests)
            each = [columns(cells) for _, cells in own.groupby("collection")]
            both = [[float(spearman(c[i], c[2])) for c in each] for i in (0, 1)]
            return among(found, "ρ {:+.2f} and {:+.2f}", *both)
        cells = with_errors(cells_of(evidence, NOMINAL, TASK, LOSS))
        effective, other, success = columns(cells)
        found = above_zero(stronger, effective, other, success, paired=True)
        both = [[float(spearman(x, success))] for x in (effective, other)]
        return among(found, "ρ {:+.2f} and {:+.2f}", *both)

    return judge


def _loss_and_attenuation(evidence: Evidence, published: Published, tests: int) -> Finding:
    if (own := _anew(evidence)) is not None:
        return of_each(own, lambda cells: spearman(cells.kp / cells.kd, cells.error), -1, tests)
    cells = with_errors(cells_of(evidence, NOMINAL, TASK, LOSS))
    return correlated(cells.kp / cells.kd, cells.error, -1, tests=tests)


def _noised(evidence: Evidence) -> pd.DataFrame:
    """Success of replays under the same noise in every cell, with regions."""
    table = evidence.table("noise", ("kp", "kd", "condition", "success"), task=TASK)
    same = table[table.condition == "same"]
    cells = same.assign(success=same.success.astype(float))
    cells = cells.groupby(["kp", "kd"], as_index=False).success.mean()
    return cells.assign(region=splits()["cloning"].regions(cells.kp, cells.kd))


def _robust(evidence: Evidence, published: Published, tests: int) -> Finding:
    cells = _noised(evidence)
    co = cells[cells.region == "CO"].success.to_numpy()
    stiff = cells[cells.region.isin(["SO", "SU"])].success.to_numpy()
    return percents(greater(co, stiff, tests=tests), co, stiff)


def _fails(evidence: Evidence, published: Published, tests: int) -> Finding:
    cells = _noised(evidence)
    stiff = cells[cells.region.isin(["SO", "SU"])].success.to_numpy()
    found = within(mean, stiff, high=published.values["share"])
    return among(found, "{:.1%}", stiff)


CLAIMS = [
    Claim(
        "variance_theorem",
        "Independent errors of the action move a joint by a variance proportional to Kp / Kd.",
        "plant and cell",
        "the simulated variance is within 10 % of the theorem's, the hold included, wherever "
        "h Kp / (2 Kd) is below 0.1",
        judge=_theorem,
        about=GRID,
    ),
    Claim(
        "variance_mass",
        "That variance does not depend on the inertia.",
        "cell",
        "over inertias it differs by at most 10 %, in the same cells",
        judge=_mass,
        about=GRID,
    ),
    Claim(
        "effective_error",
        "Success falls with the effective error √(Kp / 2 Kd) · RMS validation error.",
        CELLS,
        "rank correlation, one-sided" + OR_COLLECTIONS,
        "the correlation is not negative",
        _effective,
        about=GRID,
        anew=ANEW,
    ),
    Claim(
        "effective_beats_loss",
        "The effective error governs success, the loss alone does not.",
        CELLS,
        "−ρ of success with the effective error less |ρ| with the loss is above 0, by its "
        "bootstrap interval" + OR_COLLECTIONS,
        judge=_beats(lambda cells: cells.error),
        about=GRID,
        anew=ANEW,
    ),
    Claim(
        "effective_beats_ratio",
        "The effective error tells more of success than the ratio Kd / Kp alone.",
        CELLS,
        "−ρ of success with the effective error less |ρ| with Kd / Kp is above 0, by its "
        "bootstrap interval" + OR_COLLECTIONS,
        judge=_beats(lambda cells: cells.kd / cells.kp),
        about=GRID,
        anew=ANEW,
    ),
    Claim(
        "loss_falls_with_attenuation",
        "Gains that attenuate errors more are harder to fit.",
        CELLS,
        "rank correlation of the RMS validation error with Kp / Kd, one-sided" + OR_COLLECTIONS,
        "the correlation is not negative",
        _loss_and_attenuation,
        about=GRID,
        anew=ANEW,
    ),
    Claim(
        "noise_robustness",
        "Under the same action noise, compliant, overdamped gains succeed more than stiff ones.",
        "cell",
        "success of replays of cells in CO against stiff ones, one-sided Mann-Whitney",
        "success in CO is not greater",
        _robust,
        about=GRID,
    ),
    Claim(
        "noise_stiff_fails",
        "Under that noise stiff gains fail completely.",
        "cell",
        "mean success of stiff cells is at most 5 %, by its bootstrap interval",
        judge=_fails,
        about=GRID,
    ),
]
