"""One row per cell out of what its stages wrote."""

from collections.abc import Sequence
from pathlib import Path

import pandas as pd

from t2l.artefacts import read_table
from t2l.bc.rollout import COLUMNS

CELL_COLUMNS = (
    "kp",
    "kd",
    "replay_success",
    "replays",
    "validation_loss",
    "success",
    "rollouts",
    "time_to_success_s",
)


def summarise(
    replays: Sequence[Path | str], losses: Sequence[Path | str], rollouts: Sequence[Path | str]
) -> tuple[pd.DataFrame, pd.DataFrame]:
    """All rollouts of a task, and one row per cell with columns `CELL_COLUMNS`.

    Args:
        replays, losses, rollouts: the tables of each cell, in the same order of cells.

    Raises:
        ArtefactError: a table is missing, cut short or foreign.
    """
    rows, tables = [], []
    for replay_path, loss_path, rollout_path in zip(replays, losses, rollouts, strict=True):
        replayed = read_table(replay_path, ("success",))
        loss = read_table(loss_path, ("epoch", "validation_loss"))
        table = read_table(rollout_path, COLUMNS)
        tables.append(table)
        rows.append(
            (
                table.kp.iloc[0],
                table.kd.iloc[0],
                replayed.success.mean(),
                len(replayed),
                loss.sort_values("epoch").validation_loss.iloc[-1],
                table.success.mean(),
                len(table),
                table.time_to_success_s.mean(),
            )
        )
    return pd.concat(tables, ignore_index=True), pd.DataFrame(rows, columns=list(CELL_COLUMNS))
