"""The exported robot, stepped by MuJoCo alone, against t2l's own prediction of recordings."""

import importlib.util
import json
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from t2l.identify.initial_state import start_state
from t2l.identify.model import Model
from t2l.identify.prediction import Predictor, Request
from t2l.recordings.recording import Recording


def difference(
    folder: Path, model: Model, layout, u: np.ndarray, recordings: Sequence[Recording]
) -> float:
    """RMS in rad between what robot.py of a folder and t2l predict of recordings, from balance.

    Args:
        folder: that was exported with the gains of `recordings`, which all have the same.
    """
    predictor = Predictor(model.robot, recordings, threads=1, in_balance=True)
    (ours,), (dq,) = predictor.predict([Request(layout, u[None])], velocity=True)
    lead_s = json.loads((folder / "export.json").read_text())["log_lead_s"]
    first = [velocity[0] for velocity in predictor.samples.by_row(dq[0])]
    theirs = predictor.samples.of(
        [replay(folder, r, lead_s, at) for r, at in zip(recordings, first, strict=True)]
    )
    return float(np.sqrt(np.nanmean((theirs - ours[0]) ** 2)))


def replay(
    folder: Path, recording: Recording, lead_s: float = 0.0, first_dq: np.ndarray | None = None
) -> np.ndarray:
    """Positions (n, njoint) at a recording's rows of the robot that a folder holds, rad.

    Args:
        lead_s: by how much commands are in force before their time.
        first_dq: (njoint,) rad/s with which it starts; where not given or NaN, as measured.
    """
    spec = importlib.util.spec_from_file_location("exported_robot", folder / "robot.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    robot = module.Robot()
    ticks = np.arange(int(np.ceil(recording.taken_s.max() / robot.period_s)) + 2)
    commands = _commands(recording, ticks, robot.period_s, lead_s)
    start_q, start_dq = start_state(recording)
    if first_dq is not None:
        start_dq = np.where(np.isnan(first_dq), start_dq, first_dq)
    robot.start(start_q - start_dq * recording.skew, start_dq, commands[0])
    q = np.empty((len(ticks), len(recording.joints)))
    for tick in ticks:
        q[tick] = robot.q
        robot.step(commands[tick])
    at = recording.taken_s.T / robot.period_s
    return np.column_stack([np.interp(x, ticks, y) for x, y in zip(at, q.T, strict=True)])


def _commands(
    recording: Recording, ticks: np.ndarray, period_s: float, lead_s: float
) -> np.ndarray:
    """q_des (ntick, njoint) in force, rad; between two ticks it is linear."""
    elapsed = recording.time - recording.time[0]
    row = np.searchsorted(elapsed, ticks * period_s + 1e-6, side="right") - 1
    led = np.minimum(ticks + lead_s / period_s, ticks[-1])
    columns = recording.q_des[row].T
    return np.column_stack([np.interp(led, ticks, column) for column in columns])
