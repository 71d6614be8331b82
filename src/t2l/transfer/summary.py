"""From rollouts to one row a cell."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from t2l.gains import Cell
from t2l.rl.choice import Choice
from t2l.rl.constraints import Evaluation

if TYPE_CHECKING:
    import pandas as pd


def cell_table(
    rollouts: Sequence["pd.DataFrame"], chosen: Sequence[tuple[Cell, Choice, Evaluation]]
) -> "pd.DataFrame":
    """One row a cell: what was tuned, what it came to in simulation, and on the robot.

    Errors are means over rollouts; `jitter_rate`, `stopped_rate` and successes are shares, the
    first of rollouts that lasted long enough to tell.

    Args:
        rollouts: a cell's, as `t2l.transfer.errors.rollout_table` makes them.
        chosen: in the same order.
    """
    import pandas as pd

    rows = []
    for table, (cell, choice, evaluation) in zip(rollouts, chosen, strict=True):
        proximal, distal = choice.action_scale
        rows.append(
            {
                "kp": cell.kp,
                "kd": cell.kd,
                "action_scale_proximal": proximal,
                "action_scale_distal": distal,
                **choice.reward_weights,
                "objective": evaluation.objective,
                # of the chosen trial, over its 100 episodes
                "success_sim_100": evaluation.success,
                "trajectory_error": np.nanmean(table.trajectory_error),
                "nn_error": np.nanmean(table.nn_error),
                "jitter_rate": table.jitter_failure.astype(float).mean(),
                "success_real": table.success.mean(),
                "success_sim": table.success_sim.mean(),
                "stopped_rate": (table.stopped != "").mean(),
                "rollouts": len(table),
            }
        )
    return pd.DataFrame(rows).sort_values(["kd", "kp"], ignore_index=True)


def best_and_worst(rollouts: "pd.DataFrame") -> dict[str, tuple[Cell, int, float]]:
    """The cells with the least and the greatest error, each with its median rollout and its E.

    Args:
        rollouts: of one condition, columns kp, kd, rollout, trajectory_error.
    """
    known = rollouts.dropna(subset="trajectory_error")
    by_cell = known.groupby(["kp", "kd"]).trajectory_error.mean()
    found = {}
    for word, gains in (("least error", by_cell.idxmin()), ("greatest error", by_cell.idxmax())):
        own = known[(known.kp == gains[0]) & (known.kd == gains[1])]
        middle = own.sort_values("trajectory_error").iloc[len(own) // 2]
        found[word] = (Cell(*gains), int(middle.rollout), float(middle.trajectory_error))
    return found
