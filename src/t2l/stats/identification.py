"""What identification found, beside what is true of a robot that is a simulation."""

from collections.abc import Mapping, Sequence

import numpy as np
import pandas as pd

from t2l.gains import Cell
from t2l.sim.training_simulator import Parameters

COLUMNS = ("kp", "kd", "joint", "parameter", "identified", "true", "ratio")


def over_true(
    found: Mapping[Cell, Parameters], truth: Mapping[str, np.ndarray], joints: Sequence[str]
) -> pd.DataFrame:
    """One row a cell, parameter and joint: columns `COLUMNS`; a ratio is NaN where 0 is true.

    Args:
        found: parameters of the training simulator, (njoint,) each.
        truth: see `t2l.hardware.Backend.truth`.
    """
    parts = []
    for cell, parameters in found.items():
        scale, static = truth["torque_scale"], parameters["static_friction"]
        pairs = {
            "Kp": (parameters["stiffness"], scale * cell.kp),
            "Kd": (parameters["damping"], scale * cell.kd),
            "armature": (parameters["armature"], truth["armature"]),
            "sliding friction": (
                static * parameters["dynamic_friction_ratio"],
                truth["sliding_friction"],
            ),
            "breakaway": (static, truth["breakaway"]),
            "viscous friction": (parameters["viscous_friction"], truth["viscous_friction"]),
        }
        for name, (identified, true) in pairs.items():
            ratio = np.divide(
                identified, true, out=np.full(len(joints), np.nan), where=np.asarray(true) > 0
            )
            columns = (cell.kp, cell.kd, list(joints), name, identified, true, ratio)
            parts.append(pd.DataFrame(dict(zip(COLUMNS, columns, strict=True))))
    return pd.concat(parts, ignore_index=True)


def printable(table: pd.DataFrame) -> pd.DataFrame:
    """A row a joint, a column a parameter: median over cells of identified over true, and range."""

    def text(ratios: pd.Series) -> str:
        low, middle, high = ratios.quantile([0, 0.5, 1])
        if np.isnan(middle):
            return "true is 0"
        # what all cells share has no range
        if high - low < 5e-3 * middle:
            return f"{middle:.2f}"
        return f"{middle:.2f} ({low:.2f} to {high:.2f})"

    wide = table.groupby(["joint", "parameter"]).ratio.apply(text).unstack()
    ordered = wide.loc[table.joint.unique(), table.parameter.unique()]
    return ordered.reset_index().rename_axis(columns=None)
