"""Do regions of gains differ where demonstrations and starts are drawn anew?

All policies of a collection share its demonstrations and starts, and so their luck. Hence the
collection is the unit: a contrast of regions, or a slope, is one number of each collection, and an
interval comes from how these numbers scatter. Cells are the same in all of them, so such an
interval speaks of the cells at hand. Of other cells between them speaks a mixed model whose random
effects are collection and cell, crossed.
"""

import warnings
from collections.abc import Mapping, Sequence
from contextlib import suppress
from math import nan

import numpy as np
import pandas as pd
from scipy.stats import t
from statsmodels.regression.mixed_linear_model import MixedLM
from statsmodels.tools.sm_exceptions import ConvergenceWarning

from t2l.gains import Cell, Grid
from t2l.names import heading, with_minus
from t2l.stats.regions import REGIONS
from t2l.stats.slopes import share_slopes
from t2l.stats.text import rate
from t2l.stats.verdict import ALPHA, Finding, Verdict

COLUMNS = ("collection", "kp", "kd", "success", "rollouts")
FEWEST = 5  # collections: with fewer, Student's t asks for more than three errors
UNIT = "collection (mean over training seeds)"
VERY_STIFF_KP = 1024  # N·m/rad, the columns that the lead over SO rested on in one collection


def over_collections(values: np.ndarray, sign: int = 1, tests: int = 1) -> Finding:
    """The mean of one number of each collection has the claimed sign.

    Reproduced where Student's interval lies on that side of zero, not reproduced where it lies on
    the other; else, or with too few collections, it cannot be told.

    Args:
        values: (n,).
        tests: that the interval is corrected for: it covers 1 − 0.05 / tests.
    """
    n = len(values)
    if n < FEWEST or not np.isfinite(values).all():
        return Finding(Verdict.CANNOT_TELL, n, float(np.mean(values)) if n else nan, unit=UNIT)
    error = float(values.std(ddof=1) / np.sqrt(n))
    return _by_interval(float(values.mean()), error, n - 1, n, sign, tests)


def _by_interval(
    value: float, error: float, freedom: int, n: int, sign: int = 1, tests: int = 1
) -> Finding:
    half = float(t.ppf(1 - ALPHA / 2 / tests, freedom)) * error
    lower, upper = value - half, value + half
    if min(sign * lower, sign * upper) > 0:
        verdict = Verdict.REPRODUCED
    elif max(sign * lower, sign * upper) < 0:
        verdict = Verdict.NOT_REPRODUCED
    else:
        verdict = Verdict.CANNOT_TELL
    return Finding(verdict, n, value, lower, upper, unit=UNIT)


def by_collection(cells: pd.DataFrame, grid: Grid, *more: str) -> pd.DataFrame:
    """A row a collection and cell out of one a policy: means over training seeds.

    Collections that lack cells are left out.

    Args:
        cells: columns `COLUMNS` and `more`.

    Returns:
        Columns collection, kp, kd, region, success, rollouts, successes, and means of `more`.
    """
    known = cells.assign(successes=cells.success * cells.rollouts)
    own = known.groupby(["collection", "kp", "kd"], as_index=False).agg(
        success=("success", "mean"), rollouts=("rollouts", "sum"), successes=("successes", "sum"),
        **{column: (column, "mean") for column in more},
    )  # fmt: skip
    # one that lacks cells would weigh regions otherwise than the rest
    found = own.groupby("collection").kp.transform("size")
    own = own[found == found.max()]
    region = [grid.region(Cell(kp, kd)) for kp, kd in zip(own.kp, own.kd, strict=True)]
    return own.assign(region=region)


def contrast(own: pd.DataFrame, outside: Sequence[str]) -> np.ndarray:
    """(n,) of each collection the mean success of CO less that of the cells outside.

    Args:
        own: as `by_collection` makes it.
        outside: regions.
    """
    inside = own[own.region == "CO"].groupby("collection").success.mean()
    other = own[own.region.isin(outside)].groupby("collection").success.mean()
    return (inside - other).dropna().to_numpy()


def slopes(own: pd.DataFrame) -> tuple[np.ndarray, np.ndarray]:
    """(n,) each: change of the log odds of success per doubling of Kp and of Kd, a collection."""
    fits = [
        share_slopes(one.kp, one.kd, one.successes, one.rollouts)
        for _, one in own.groupby("collection")
    ]
    return np.array([fit.kp for fit in fits]), np.array([fit.kd for fit in fits])


def crossed(own: pd.DataFrame) -> Finding:
    """CO less SO by a mixed model, with collection and cell as crossed random effects.

    Success is a mean of its region, plus what the collection adds, what it adds to one region, what
    the cell adds, and the rest; variances by restricted maximum likelihood (statsmodels' MixedLM).
    The interval is Student's, with as many degrees of freedom as cells less the two means.
    """
    both = own[own.region.isin(["CO", "SO"])]
    cells = both[["region", "kp", "kd"]].drop_duplicates().region.value_counts()
    n = both.collection.nunique()
    if n < FEWEST or len(cells) < 2 or cells.min() < 2:
        return Finding(Verdict.CANNOT_TELL, n)
    named = both.assign(
        inside=(both.region == "CO").astype(float),
        cell=both.kp.astype(str) + "_" + both.kd.astype(str),
        all=0,
    )
    effects = {
        "collection": "0 + C(collection)",
        "collection_region": "0 + C(collection):C(region)",
        "cell": "0 + C(cell)",
    }
    with warnings.catch_warnings():
        # a variance of zero is at the bound of what variances may be
        warnings.simplefilter("ignore", ConvergenceWarning)
        model = MixedLM.from_formula("success ~ inside", named, groups="all", vc_formula=effects)
        # gradients mislead: L-BFGS stops far from the maximum, and says that it converged
        fits = []
        for method in ("nm", "powell"):
            # on its way a search may meet variances that leave nothing to solve
            with suppress(np.linalg.LinAlgError):
                fits.append(model.fit(reml=True, method=method))
    if not fits:
        return Finding(Verdict.CANNOT_TELL, n)
    fit = max(fits, key=lambda one: one.llf)
    value, error = float(fit.fe_params["inside"]), float(fit.bse_fe["inside"])
    return _by_interval(value, error, int(cells.sum()) - 2, n)


def best_elsewhere(cells: Mapping[str, pd.DataFrame]) -> pd.DataFrame:
    """Of several ways of training, for each cell and collection the one that is best in the others.

    So what chose is not what reports.

    Args:
        cells: by name of a variant, one row a policy, columns `COLUMNS`.
    """
    every = pd.concat([own.assign(way=name) for name, own in cells.items()], ignore_index=True)
    gains, parts = ["kp", "kd"], []
    for number, own in every.groupby("collection"):
        others = every[every.collection != number]
        means = others.groupby([*gains, "way"], as_index=False).success.mean()
        best = means.loc[means.groupby(gains).success.idxmax(), [*gains, "way"]]
        parts.append(own.merge(best))
    return pd.concat(parts, ignore_index=True)[[*COLUMNS]]


def collections_table(cells: Mapping[str, pd.DataFrame], grid: Grid) -> pd.DataFrame:
    """CO against the others, and both slopes, with collections as the unit of replication.

    Args:
        cells: by name of a variant, one row a policy, columns `COLUMNS`.

    Returns:
        A row each: name, collections; success_co, success_so, success_cu, success_su; and of
        co_so, co_so_below_1024 (without stiffer cells), co_rest, co_so_crossed, beta_kp, beta_kd:
        the number, and `_lower`, `_upper` of its 95 % interval; `verdict` on co_so.
    """
    rows = []
    for name, policies in cells.items():
        own = by_collection(policies, grid)
        means = own.groupby("region").success.mean()
        below = own[own.kp < VERY_STIFF_KP]
        kp, kd = slopes(own)
        numbers = {
            "co_so": over_collections(contrast(own, ["SO"])),
            "co_so_below_1024": over_collections(contrast(below, ["SO"])),
            # of overdamped cells alone it would be the same again
            "co_rest": over_collections(contrast(own, REGIONS[1:]))
            if set(own.region) > {"CO", "SO"}
            else Finding(Verdict.CANNOT_TELL),
            "co_so_crossed": crossed(own),
            "beta_kp": over_collections(kp, -1),
            "beta_kd": over_collections(kd),
        }
        row = {"name": name, "collections": own.collection.nunique()}
        row |= {f"success_{word.lower()}": means.get(word, nan) for word in REGIONS}
        for key, number in numbers.items():
            row |= {key: number.value, f"{key}_lower": number.lower, f"{key}_upper": number.upper}
        rows.append({**row, "verdict": str(numbers["co_so"].verdict)})
    return pd.DataFrame(rows)


def printable_collections(table: pd.DataFrame) -> pd.DataFrame:
    """`collections_table` as text."""

    def points(key: str) -> list[str]:
        columns = table[[key, f"{key}_lower", f"{key}_upper"]]
        return [_points(*row) for row in columns.itertuples(index=False)]

    def slope(key: str) -> list[str]:
        columns = table[[key, f"{key}_lower", f"{key}_upper"]]
        return [_slope(*row) for row in columns.itertuples(index=False)]

    return pd.DataFrame(
        {
            "Collections drawn anew": [heading(name) for name in table.name],
            "n": table.collections.astype(str),
            "CO": [rate(value) for value in table.success_co],
            "SO": [rate(value) for value in table.success_so],
            "CO − SO": points("co_so"),
            "… below Kp 1024": points("co_so_below_1024"),
            "… of other cells too": points("co_so_crossed"),
            "CO − rest": points("co_rest"),
            "β Kp": slope("beta_kp"),
            "β Kd": slope("beta_kd"),
            "CO beats SO": table.verdict,
        }
    )


def _slope(value: float, lower: float, upper: float) -> str:
    if np.isnan(value):
        return ""
    ends = "" if np.isnan(lower) else f" ({lower:+.2f} to {upper:+.2f})"
    return with_minus(f"{value:+.2f}{ends}")


def _points(value: float, lower: float, upper: float) -> str:
    if np.isnan(value):
        return ""
    # numerics: a half is rounded alike on every machine
    value, lower, upper = (round(100 * x, 9) for x in (value, lower, upper))
    ends = "" if np.isnan(lower) else f" ({lower:+.1f} to {upper:+.1f})"
    return with_minus(f"{value:+.1f}{ends}")
