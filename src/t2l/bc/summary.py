"""One row per policy out of what its stages wrote."""

from collections.abc import Mapping, Sequence
from pathlib import Path

import pandas as pd

from t2l.artefacts import read_table
from t2l.bc.rollout import COLUMNS
from t2l.bc.training import LOSS_COLUMNS
from t2l.gains import Cell

CELL_COLUMNS = (
    "kp",
    "kd",
    "seed",
    "replay_success",
    "replays",
    "demonstrations",
    "validation_loss",
    "validation_mse_rad2",
    "success",
    "rollouts",
    "time_to_success_s",
)


def summarise(
    replays: Sequence[Path | str],
    losses: Sequence[Path | str],
    rollouts: Sequence[Path | str],
    demonstrations: Mapping[str, int],
) -> tuple[pd.DataFrame, pd.DataFrame]:
    """All rollouts of a task's variant with their `seed`, and a row a policy: `CELL_COLUMNS`.

    Args:
        replays, losses, rollouts: the tables of each policy, in the same order of policies.
        demonstrations: how many a cell's policies are to be trained on, by its name; fewer where
            fewer survive retargeting.

    Raises:
        ArtefactError: a table is missing, cut short or foreign.
    """
    rows, tables = [], []
    for replay_path, loss_path, rollout_path in zip(replays, losses, rollouts, strict=True):
        replayed = read_table(replay_path, ("success",))
        last = read_table(loss_path, LOSS_COLUMNS).sort_values("epoch").iloc[-1]
        table = read_table(rollout_path, COLUMNS)
        seed = int(last.seed)
        tables.append(table.assign(seed=seed))
        rows.append(
            (
                table.kp.iloc[0],
                table.kd.iloc[0],
                seed,
                replayed.success.mean(),
                len(replayed),
                demonstrations[Cell(table.kp.iloc[0], table.kd.iloc[0]).name],
                last.validation_loss,
                last.validation_mse_rad2,
                table.success.mean(),
                len(table),
                table.time_to_success_s.mean(),
            )
        )
    return pd.concat(tables, ignore_index=True), pd.DataFrame(rows, columns=list(CELL_COLUMNS))
