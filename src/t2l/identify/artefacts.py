"""An identified cell on disk: parameters a person can read, and how they were found."""

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from t2l.artefacts import read_yaml, reading, write_table, write_text
from t2l.gains import Cell
from t2l.identify.actuator_parameters import PARAMETERS, Parameters
from t2l.identify.actuators import Identified
from t2l.recordings.recording import Recording

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
        f"# the training simulator under {cell}, identified from one recording",
        f"kp: {cell.kp:g}  # N·m/rad, commanded",
        f"kd: {cell.kd:g}  # N·m·s/rad, commanded",
        f"mse_rad2: {found.mse:.6g}  # S*, of positions over time",
        f"loss: {found.losses[-1]:.6g}  # spectral, of positions and velocities",
        f"joints: [{', '.join(joints)}]",
        "parameters:",
    ]
    for p in PARAMETERS:
        numbers = ", ".join(f"{value:.6g}" for value in found.parameters[p.name])
        lines.append(f"  {p.name}: [{numbers}]  # {p.unit}, {p.lower:g} to {p.upper:g}")
    on_bound = ", ".join(f"{name} of {joints[joint]}" for name, joint in found.bounds)
    lines.append(f"on_bound: [{on_bound}]")
    write_text("\n".join(lines) + "\n", path)


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
    """A cell's row: gains, S*, loss, and how many parameters ended on a bound.

    Raises:
        ArtefactError: `write_parameters` did not make that file.
    """
    numbers = ("kp", "kd", "mse_rad2", "loss")
    content = read_yaml(path, WHAT, (*numbers, "on_bound"))
    with reading(path, WHAT):
        return {key: float(content[key]) for key in numbers} | {
            "on_bound": len(content["on_bound"]),
            "parameters_on_bound": "; ".join(content["on_bound"]),
        }


def write_losses(found: Identified, cell: Cell, path: Path | str) -> None:
    """Write the least loss so far of each iteration, columns `LOSS_COLUMNS`."""
    import pandas as pd

    table = pd.DataFrame({"iteration": np.arange(len(found.losses)), "loss": found.losses})
    write_table(table.assign(kp=cell.kp, kd=cell.kd)[list(LOSS_COLUMNS)], path)


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
