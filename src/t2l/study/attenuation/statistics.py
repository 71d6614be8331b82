"""Tables of attenuation: theory against simulation, what tells success, replays under noise.

Cells are the unit of replication of every interval here.
"""

from collections.abc import Mapping

import numpy as np
import pandas as pd
from scipy.stats import t as student

from t2l.advise.attenuation import SMALL
from t2l.gains import Cell, Grid
from t2l.names import heading
from t2l.stats.rank import rank_correlations
from t2l.stats.text import interval, rate
from t2l.study.attenuation.noise import CONDITIONS
from t2l.study.attenuation.success import PREDICTORS, predictors
from t2l.study.published.numbers import REGIONS

NAMES = {
    "effective_error": "effective error",
    "loss": "validation loss",
    "damping_over_stiffness": "Kd / Kp",
}


def variance_table(held: pd.DataFrame) -> pd.DataFrame:
    """How the simulated variance compares with theory, and whether inertia matters.

    Args:
        held: one row a plant and cell, see `rack.held_noise`.

    Returns:
        One row a quantity and plant: value with its 95 % t interval over `cells`.
    """
    small = held.theorem_rad2 / held.noise_rad**2 < SMALL
    over_theorem = held.variance_rad2 / held.theorem_rad2
    over_exact = held.variance_rad2 / held.exact_rad2
    slopes = pd.Series(
        [
            np.polyfit(np.log(own.inertia_kg_m2), np.log(own.variance_rad2), 1)[0]
            for _, own in held[small].groupby(["kp", "kd"])
            if own.inertia_kg_m2.nunique() > 1
        ],
        dtype=float,
    )
    rows = []
    for plant in held.plant.unique():
        own = held.plant == plant
        rows.append(("simulated / theorem, small h Kp/(2 Kd)", plant, over_theorem[own & small]))
        rows.append(("simulated / exact", plant, over_exact[own]))
    rows.append(("d ln variance / d ln inertia, small h Kp/(2 Kd)", "all", slopes))
    return pd.DataFrame(
        [(quantity, plant, *_mean(values)) for quantity, plant, values in rows],
        columns=["quantity", "plant", "value", "low", "high", "cells"],
    )


def _mean(values: pd.Series) -> tuple[float, float, float, int]:
    n = len(values)
    half = values.std() / np.sqrt(n) * student.ppf(0.975, n - 1) if n > 1 else np.nan
    return values.mean(), values.mean() - half, values.mean() + half, n


def printable_variance(table: pd.DataFrame) -> pd.DataFrame:
    """`variance_table` as text."""
    rows = zip(table.value, table.low, table.high, strict=True)
    return pd.DataFrame(
        {
            "Quantity": table.quantity,
            "Joint": table.plant,
            "Mean over cells (95 %)": [interval(*row, digits=3).replace("+", "") for row in rows],
            "Cells": table.cells.astype(str),
        }
    )


def effective_error_table(grids: Mapping[str, pd.DataFrame], hold_s: float) -> pd.DataFrame:
    """Spearman's ρ of success with what could tell it.

    Args:
        grids: by name, one row a cell: kp, kd, success, loss, seeds.

    Returns:
        One row a grid and predictor: rho with a 95 % bootstrap interval over `cells`; `expected`,
        its sign if the study is right; and by how much |ρ| of the effective error is `stronger`.
    """
    rows = []
    for name, cells in grids.items():
        table = predictors(cells, hold_s)
        values = {key: table[key].to_numpy() for key in PREDICTORS}
        found, stronger = rank_correlations(values, table.success.to_numpy())
        for key, one in found.items():
            more = stronger.get(key, (np.nan, np.nan, np.nan))
            ends = (one.rho, one.low, one.high, one.cells)
            rows.append((name, key, PREDICTORS[key], *ends, int(cells.seeds.min()), *more))
    return pd.DataFrame(
        rows,
        columns=[
            *("grid", "predictor", "expected", "rho", "low", "high", "cells", "seeds"),
            *("stronger", "stronger_low", "stronger_high"),
        ],
    )


def printable_effective_error(table: pd.DataFrame) -> pd.DataFrame:
    """`effective_error_table` as text."""
    rho = zip(table.rho, table.low, table.high, strict=True)
    more = zip(table.stronger, table.stronger_low, table.stronger_high, strict=True)
    return pd.DataFrame(
        {
            "Grid": [heading(name) for name in table.grid],
            "Predictor": [NAMES[name] for name in table.predictor],
            "ρ with success (95 %)": [interval(*row) for row in rho],
            "|ρ| of effective error is stronger by": [
                "" if name == "effective_error" else interval(*row)
                for name, row in zip(table.predictor, more, strict=True)
            ],
            "Cells": table.cells.astype(str),
            "Seeds": table.seeds.astype(str),
        }
    )


def noise_table(
    replays: Mapping[str, pd.DataFrame],
    undisturbed: Mapping[str, pd.DataFrame],
    grid: Grid,
) -> pd.DataFrame:
    """Success of open-loop replays under noise by region, and how it follows Kp / Kd.

    Args:
        replays: per task, one row a replay, see `noise.COLUMNS`.
        undisturbed: per task, one row a cell: kp, kd, replay_success.

    Returns:
        One row a task and condition (`none`, then those of noise): largest and smallest magnitude
        of the noise in rad; success as a fraction of the replays, mean over the cells of each
        region; Spearman's ρ of success with Kp / Kd over `cells`, with its 95 % interval.
    """
    rows = []
    for task, table in replays.items():
        for condition in ("none", *CONDITIONS):
            own = table[table.condition == condition]
            cells = own.groupby(["kp", "kd"], as_index=False).success.mean()
            if condition == "none":
                cells = undisturbed[task].groupby(["kp", "kd"], as_index=False).agg(
                    success=("replay_success", "mean")
                )  # fmt: skip
            regions = [grid.region(Cell(*g)) for g in zip(cells.kp, cells.kd, strict=True)]
            success = cells.success.groupby(regions).mean()
            ratio = {"ratio": (cells.kp / cells.kd).to_numpy()}
            rho = rank_correlations(ratio, cells.success.to_numpy())[0]["ratio"]
            sizes = (own.magnitude_rad.min(), own.magnitude_rad.max()) if len(own) else (0.0, 0.0)
            by_region = (success.get(region, np.nan) for region in REGIONS)
            rows.append(
                (task, condition, *sizes, *by_region, rho.rho, rho.low, rho.high, rho.cells)
            )
    return pd.DataFrame(
        rows,
        columns=[
            *("task", "condition", "smallest_rad", "largest_rad"),
            *(f"success_{region.lower()}" for region in REGIONS),
            *("rho", "low", "high", "cells"),
        ],
    )


def printable_noise(table: pd.DataFrame) -> pd.DataFrame:
    """`noise_table` as text."""
    words = {"none": "none", "same": "the same in every cell", "own": "each cell's own"}
    rho = zip(table.rho, table.low, table.high, strict=True)
    return pd.DataFrame(
        {
            "Task": [heading(name) for name in table.task],
            "Noise": [words[condition] for condition in table.condition],
            "Up to [mrad]": [
                f"{1000 * low:.1f}" if low == high else f"{1000 * low:.1f} to {1000 * high:.1f}"
                for low, high in zip(table.smallest_rad, table.largest_rad, strict=True)
            ],
            **{f"{r}": [rate(v) for v in table[f"success_{r.lower()}"]] for r in REGIONS},
            "ρ with Kp / Kd (95 %)": [interval(*row) for row in rho],
            "Cells": table.cells.astype(str),
        }
    )
