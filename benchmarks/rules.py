"""The scoreboard's rules on the study's own published grids: can they tell what it says?

`T2L_STUDY_DATA` names the folder with `paper_results.json`. Each grid takes the place of ours: what
the study found over its own cells should come out reproduced, and a part of its cells shows what a
smaller design can tell.
"""

import json
import os
from pathlib import Path

import numpy as np
import pandas as pd

from benchmarks.published import by_cell
from t2l.study.evidence import Evidence, source_of
from t2l.study.scoreboard.table import CHAINS

CLAIMS = {claim.key: claim for claims in CHAINS.values() for claim in claims}
CLONING = (
    *("co_block_stack", "stiffness_hurts", "damping_helps", "compliant_once_overdamped"),
    *("overdamped_once_compliant", "loss_misleads", "effective_error", "effective_beats_loss"),
    "effective_beats_ratio",
)
TRANSFER = (
    *("transfer_joint_reach", "slopes_joint_reach", "inverse_relation"),
    *("identification_so_lowest", "identification_factor", "identification_co_highest"),
)
ROLLOUTS = 200  # a cell of the page
PARTS = {
    "transfer": lambda cells: cells,
    "transfer, Kp {16, 128, 512} × Kd {2, 8, 16, 24}": lambda cells: cells[
        cells.kp.isin([16, 128, 512]) & cells.kd.isin([2, 8, 16, 24])
    ],
}


def run() -> pd.DataFrame:
    """A row a claim and grid."""
    data = os.environ.get("T2L_STUDY_DATA")
    if not data:
        return pd.DataFrame({"skipped": ["T2L_STUDY_DATA does not name the folder of the data"]})
    study = json.loads((Path(data) / "paper_results.json").read_text())
    rows = []
    for task, grid in study["bc_success"].items():
        if isinstance(grid, dict):
            rows += _judged(task, CLONING, _cloning(grid))
    error = table(study["sim2real_error"], "mse").rename(columns={"mse": "trajectory_error"})
    identified = table(study["sysid_log_error"], "log_error")
    # its base is not known; only factors depend on it
    identified["s_star"] = np.exp(identified.log_error)
    for name, part in PARTS.items():
        cells = part(error)
        evidence = {
            "sim_to_real/joint_reach/rollouts": cells,
            # the study deploys policies that work and keep the limits
            "sim_to_real/joint_reach/cells": cells.assign(success_sim_100=1.0, objective=2.0),
            "sim_to_real/identification": part(identified),
        }
        rows += _judged(name, TRANSFER, evidence)
    return pd.DataFrame(rows, columns=["grid", "claim", "found", "n", "p", "verdict"])


def table(grid: dict, key: str) -> pd.DataFrame:
    """A published grid, a row a cell: kp, kd and the key."""
    rows = [(cell.kp, cell.kd, value) for cell, value in by_cell(grid, key).items()]
    return pd.DataFrame(rows, columns=["kp", "kd", key])


def _cloning(grid: dict) -> dict[str, pd.DataFrame]:
    cells = table(grid, "success").merge(table(grid, "final_loss"))
    share = cells.success / (100 if cells.success.max() > 1 else 1)
    columns = {"success": share, "rollouts": ROLLOUTS, "validation_mse_rad2": cells.final_loss}
    return {"block_stack/nominal/cells": cells.assign(**columns)}


def _judged(grid: str, keys: tuple[str, ...], tables: dict[str, pd.DataFrame]) -> list[tuple]:
    evidence = Evidence(
        [(source_of(f"results/study/{path}.parquet"), rows) for path, rows in tables.items()]
    )
    rows = []
    for key in keys:
        found = CLAIMS[key].finding(evidence)
        ends = f"{found.value:+.2f} ({found.lower:+.2f} to {found.upper:+.2f})"
        rows.append((grid, key, ends, found.n, f"{found.p:.2g}", str(found.verdict)))
    return rows
