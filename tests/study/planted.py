"""Tables that hold a trend, or none, as the stages of the workflow write them."""

from collections.abc import Mapping
from itertools import product
from pathlib import Path

import numpy as np
import pandas as pd

from t2l.study.evidence import Evidence, Source, source_of
from t2l.study.published.numbers import splits

CLONING = list(product([32, 128, 512, 2048], [2, 8, 32, 128]))
TRANSFER = list(product([16, 128, 512], [2, 8, 16, 24]))
CORNERS = list(product([16, 512], [2, 24]))


def evidence(study: str = "planted", **tables: pd.DataFrame) -> Evidence:
    """Of tables by their paths below results/STUDY, with __ for a slash."""
    return Evidence(read(study, tables))


def read(study: str, tables: Mapping[str, pd.DataFrame]) -> list[tuple[Source, pd.DataFrame]]:
    """The tables of one study with where each lies."""
    read = []
    for name, table in tables.items():
        ending = ".csv" if name.startswith("tables") else ".parquet"
        path = Path("results") / study / (name.replace("__", "/") + ending)
        source = source_of(path)
        assert source, path
        read.append((source, table))
    return read


def frame(cells, kind, **columns) -> pd.DataFrame:
    """A row a cell; a column is a number, or a function of kp, kd and region."""
    kp, kd = np.array(cells, float).T
    region = splits()[kind].regions(kp, kd)
    made = {"kp": kp, "kd": kd}
    for name, value in columns.items():
        if callable(value):
            value = [value(*cell) for cell in zip(kp, kd, region, strict=True)]
        made[name] = value
    return pd.DataFrame(made)


def cloning(cells=CLONING, loss=None, **by_region) -> pd.DataFrame:
    """Success by region, the same but for a trifle that differs from cell to cell."""
    success = {"CO": 0.3, "SO": 0.3, "CU": 0.3, "SU": 0.3} | by_region

    def planted(kp, kd, region):
        return success[region] + 0.01 * ((7 * np.log2(kp) + 3 * np.log2(kd)) % 5)

    table = frame(cells, "cloning", success=planted, rollouts=100)
    return table if loss is None else table.assign(validation_mse_rad2=loss(table))


def transfer(cells=TRANSFER, rollouts=5, slope=0.0, jitter=None, seed=0, **columns):
    """Rollouts whose ln E rises with both gains by `slope` per doubling, and that jitter or not."""
    draw = np.random.default_rng(seed)
    jitter = jitter or (lambda kp, kd, region: 0.1)
    parts = []
    for _ in range(rollouts):
        table = frame(
            cells,
            "transfer",
            trajectory_error=lambda kp, kd, region: np.exp(
                slope * np.log2(kp * kd) + 0.1 * np.sin(37 * kp + 11 * kd) + draw.normal(0, 0.01)
            ),
            jitter_failure=lambda *cell: jitter(*cell),
            jitter_failure_sim=0.0,
            nn_error=0.0,
            **columns,
        )
        table["nn_error"] = table.trajectory_error**0.5
        parts.append(table)
    return pd.concat(parts, ignore_index=True)


def deployed(condition: str, cells=TRANSFER, objective=2.0, **planted) -> dict[str, pd.DataFrame]:
    """Rollouts as `transfer` plants them, of policies that all work in their simulator.

    Args:
        objective: of these policies; below 1 they break a limit.
    """
    folder = f"sim_to_real__{condition}"
    return {
        f"{folder}__rollouts": transfer(cells, **planted),
        f"{folder}__cells": frame(cells, "transfer", success_sim_100=1.0, objective=objective),
    }
