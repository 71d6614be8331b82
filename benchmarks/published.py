"""The study's published numbers beside ours: identification, transfer, tuning.

`T2L_STUDY_DATA` names the folder with `fr3_gain_grid/` (recordings of a real FR3) and
`paper_results.json` (the study's grids). Ours are read from `results/STUDY`, `T2L_STUDY` naming
the study (`default`). Identified recordings are kept in `results/bench/published`, so that an
interrupted run goes on where it stopped.
"""

import json
import os
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

import numpy as np
import pandas as pd
from scipy.stats import spearmanr

from benchmarks.scene import ROOT, paper
from t2l.artefacts import write_text
from t2l.gains import Cell, Grid
from t2l.identify.actuators import Settings, identify
from t2l.recordings.log import read_recording
from t2l.seeds import seed_sequence
from t2l.stats.transfer import transfer_table

FOLDER = ROOT / "results/bench/published"
PROCESSES = 2
GRID = Grid.from_section(paper()["recording_grid"])
# of the study's tuning, and the corners of ours
CORNERS = {
    Cell(16, 2): Cell(16, 1),
    Cell(16, 24): Cell(16, 24),
    Cell(512, 2): Cell(512, 1),
    Cell(512, 24): Cell(512, 24),
}


def run() -> pd.DataFrame:
    """One row a number that both have."""
    data = os.environ.get("T2L_STUDY_DATA")
    if not data:
        return pd.DataFrame({"skipped": ["T2L_STUDY_DATA does not name the folder of the data"]})
    study = json.loads((Path(data) / "paper_results.json").read_text())
    ours = ROOT / "results" / os.environ.get("T2L_STUDY", "default")
    rows = identification(Path(data) / "fr3_gain_grid", study["sysid_log_error"])
    rows += transfer(study["sim2real_error"], ours / "sim_to_real" / "joint_reach")
    rows += tuning(study["optuna"], ours / "sim_to_real")
    return pd.DataFrame(rows, columns=["what", "the study", "ours"])


def identification(folder: Path, grid: dict) -> list[tuple]:
    """S* of the real recordings: patterns are compared by ranks, the grid's scale is unknown."""
    theirs = by_cell(grid, "log_error")
    with ProcessPoolExecutor(PROCESSES) as pool:
        errors = list(pool.map(identified, (folder / f"{cell.name}.csv" for cell in theirs)))
    ours = dict(zip(theirs, np.log(errors), strict=True))
    rank, p = spearmanr(list(theirs.values()), list(ours.values()))
    return [
        ("S* of the real recordings: rank correlation of 49 cells", "", f"{rank:+.2f} (p {p:.1g})"),
        *((f"ln S*: rank correlation with log2 {gain}", ranked(theirs, gain), ranked(ours, gain))
          for gain in ("Kp", "Kd")),
        ("ln S*: mean", f"{np.mean(list(theirs.values())):.2f}",
         f"{np.mean(list(ours.values())):.2f}"),
    ]  # fmt: skip


def identified(path: Path) -> float:
    """S* of one recording, rad², with the settings of the study."""
    kept = FOLDER / f"{path.stem}.json"
    if not kept.exists():
        seed = seed_sequence(0, "identify", path.stem).generate_state(1)[0]
        found = identify(read_recording(path), Settings(**paper()["identification"]), int(seed))
        write_text(json.dumps({"mse": float(found.mse)}), kept)
    return json.loads(kept.read_text())["mse"]


def transfer(grid: dict, folder: Path) -> list[tuple]:
    """The study's table from its grid of cell means; ours from all rollouts of the condition."""
    theirs = pd.DataFrame(
        [(c.kp, c.kd, e) for c, e in by_cell(grid, "mse").items()],
        columns=["kp", "kd", "trajectory_error"],
    )
    tables = {"theirs": theirs}
    if (folder / "rollouts.parquet").exists():
        tables["ours"] = pd.read_parquet(folder / "rollouts.parquet")
    found = {
        name: transfer_table({name: table}, GRID).iloc[0].to_dict()
        for name, table in tables.items()
    }

    def row(what: str, text: str) -> tuple:
        return what, *(text.format(**found[n]) if n in found else "" for n in ("theirs", "ours"))

    return [
        row("transfer error in G^SO", "{error_so:.3g}"),
        row("transfer error outside", "{error_rest:.3g}"),
        row("β log2 Kp of ln error", "{beta_kp:+.3f} ± {beta_kp_se:.3f}"),
        row("β log2 Kd of ln error", "{beta_kd:+.3f} ± {beta_kd_se:.3f}"),
        row("p that error is greater in G^SO, over cells", "{p_cells:.2g}"),
    ]


def tuning(published: dict, folder: Path) -> list[tuple]:
    """Best success of the Optuna studies at the corners, and how many trials reach 95 %."""
    rows = []
    tasks = (("FR3 Joint-Reach", "joint_reach"), ("FR3 EE-Reach", "end_effector_reach"))
    for theirs, ours in tasks:
        for cell, corner in CORNERS.items():
            gains = (theirs, cell.kp, cell.kd)
            study = [
                file
                for file in published["files"]
                if (file["task"], file.get("kp"), file.get("kd")) == gains
            ]
            path = folder / ours / corner.name / "trials.parquet"
            if not study and not path.exists():
                continue
            rows.append(
                (
                    f"{theirs} {cell.name} ({corner.name}): best success, trials at 95 %",
                    solved(study[0]["success"]) if study else "",
                    solved(pd.read_parquet(path).success) if path.exists() else "",
                )
            )
    return rows


def solved(success) -> str:
    rates = pd.Series(success, dtype=float).fillna(0.0)
    return f"{100 * rates.max():.0f} %, {(rates >= 0.95).sum()} of {len(rates)}"


def ranked(values: dict[Cell, float], gain: str) -> str:
    gains = [cell.kp if gain == "Kp" else cell.kd for cell in values]
    rank, p = spearmanr(gains, list(values.values()))
    return f"{rank:+.2f} (p {p:.1g})"


def by_cell(grid: dict, key: str) -> dict[Cell, float]:
    """A published grid: rows by kd, columns by kp."""
    values = np.array(grid[key], float)
    return {
        Cell(kp, kd): values[i, j]
        for i, kd in enumerate(grid["kds"])
        for j, kp in enumerate(grid["kps"])
    }
