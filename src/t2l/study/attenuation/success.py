"""What may tell from gains and loss how often a cloned policy succeeds, one row a cell."""

import pandas as pd

from t2l.advise.attenuation import effective_error

# of the table of cells: one row a cell and training seed
COLUMNS = ("kp", "kd", "success", "validation_mse_rad2")
# a predictor, and whether success is to rise (+1) or to fall (-1) with it if the study is right
PREDICTORS = {"effective_error": -1, "loss": +1, "damping_over_stiffness": +1}


def by_cell(cells: pd.DataFrame) -> pd.DataFrame:
    """Means over training seeds: kp, kd, success, loss and how many `seeds` they are of.

    Args:
        cells: columns `COLUMNS`.
    """
    return cells.groupby(["kp", "kd"], as_index=False).agg(
        success=("success", "mean"),
        loss=("validation_mse_rad2", "mean"),
        seeds=("success", "size"),
    )


def predictors(cells: pd.DataFrame, hold_s: float) -> pd.DataFrame:
    """The same cells with a column for each of `PREDICTORS`.

    Args:
        cells: one row a cell: kp, kd, success and loss, a mean squared error; in rad² the effective
            error is in rad.
        hold_s: how long each command is held.
    """
    return cells.assign(
        effective_error=effective_error(cells.kp, cells.kd, cells.loss, hold_s),
        damping_over_stiffness=cells.kd / cells.kp,
    )
