"""An identified cell on disk: parameters a person can read, and how they were found."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from t2l.artefacts import read_yaml, reading, write_table, write_text
from t2l.gains import Cell
from t2l.identify.actuator_parameters import PARAMETERS
from t2l.identify.actuators import Identified
from t2l.recordings.recording import Recording
from t2l.sim.training_simulator import Parameters

if TYPE_CHECKING:
    import pandas as pd

NAMES = tuple(parameter.name for parameter in PARAMETERS)
WHAT = "identified parameters of a cell"
LOSS_COLUMNS = ("kp", "kd", "iteration", "loss")
TRACE_COLUMNS = ("kp", "kd", "joint", "time", "q_des", "q", "q_sim", "dq", "dq_sim")


def write_parameters(
    found: Identified, cell: Cell, joints: tuple[str, ...], path: Path | str
) -> None:
    """Write YAML: by joint, with units, what ended on a bound, and the error that is left."""
    lines = [
        f"# the training simulator under {cell}, as it was identified",
        f"kp: {cell.kp:g}  # N·m/rad, commanded",
        f"kd: {cell.kd:g}  # N·m·s/rad, commanded",
        f"mse_rad2: {found.mse:.6g}  # of positions, over time and joints",
        f"mse_dq_rad2_s2: {_number(found.mse_dq)}  # of velocities",
        f"s_star: {_number(found.s_star)}  # S*, the sum of both",
        f"loss: {found.losses[-1]:.6g}  # what was made small",
        f"joints: [{', '.join(joints)}]",
        "parameters:",
    ]
    for p in PARAMETERS:
        numbers = ", ".join(f"{value:.6g}" for value in found.parameters[p.name])
        lines.append(f"  {p.name}: [{numbers}]  # {p.unit}")
    on_bound = ", ".join(f"{name} of {joints[joint]}" for name, joint in found.bounds)
    lines.append(f"on_bound: [{on_bound}]")
    write_text("\n".join(lines) + "\n", path)


def _number(value: float) -> str:
    """As YAML reads it back, where there may be none."""
    return f"{value:.6g}" if np.isfinite(value) else ".nan"


def read_parameters(path: Path | str) -> Parameters:
    """The parameters (njoint,) of a file that `write_parameters` made.

    Raises:
        ArtefactError: it is not one.
    """
    content = read_yaml(path, WHAT, ("joints", "parameters"))
    with reading(path, WHAT):
        parameters = {name: np.array(content["parameters"][name], float) for name in NAMES}
        for name, values in parameters.items():
            if values.shape != (len(content["joints"]),) or not np.isfinite(values).all():
                raise ValueError(f"{name} is not one finite number a joint")
    return parameters


def summary(path: Path | str) -> dict:
    """A cell's row: gains, errors, loss, and how many parameters ended on a bound.

    `mse_rad2` is the error of positions alone, `s_star` the study's S* over positions and
    velocities.

    Raises:
        ArtefactError: `write_parameters` did not make that file.
    """
    numbers = ("kp", "kd", "mse_rad2", "mse_dq_rad2_s2", "s_star", "loss")
    content = read_yaml(path, WHAT, (*numbers, "on_bound"))
    with reading(path, WHAT):
        return {key: float(content[key]) for key in numbers} | {
            "on_bound": len(content["on_bound"]),
            "parameters_on_bound": "; ".join(content["on_bound"]),
        }


def loss_table(losses: np.ndarray, cells: Sequence[Cell | Recording]) -> "pd.DataFrame":
    """Losses (iterations, ncell) as rows, columns `LOSS_COLUMNS`.

    Args:
        cells: or the recordings of cells, whose joints have one gain.
    """
    import pandas as pd

    gains = [(float(np.ravel(c.kp)[0]), float(np.ravel(c.kd)[0])) for c in cells]
    parts = [
        pd.DataFrame({"kp": kp, "kd": kd, "iteration": np.arange(len(losses)), "loss": column})
        for (kp, kd), column in zip(gains, losses.T, strict=True)
    ]
    return pd.concat(parts, ignore_index=True)[list(LOSS_COLUMNS)]


def write_trace(recording: Recording, found: Identified, cell: Cell, path: Path | str) -> None:
    """Write measured and simulated motion at the measured rows, columns `TRACE_COLUMNS`."""
    import pandas as pd

    row = np.round((recording.time - recording.time[0]) * recording.command_rate_hz).astype(int)
    parts = []
    for j, joint in enumerate(recording.joints):
        dq = np.nan if recording.dq is None else recording.dq[:, j]
        parts.append(
            pd.DataFrame(
                {
                    "kp": cell.kp, "kd": cell.kd, "joint": joint,
                    "time": recording.time - recording.time[0], "q_des": recording.q_des[:, j],
                    "q": recording.q[:, j], "q_sim": found.q[row, j],
                    "dq": dq, "dq_sim": found.dq[row, j],
                }
            )
        )  # fmt: skip
    write_table(pd.concat(parts, ignore_index=True)[list(TRACE_COLUMNS)], path)


def summarise(paths: list[Path | str]) -> "pd.DataFrame":
    """One row a cell, by Kd and Kp."""
    import pandas as pd

    table = pd.DataFrame([summary(path) for path in paths])
    return table.sort_values(["kd", "kp"], ignore_index=True)
