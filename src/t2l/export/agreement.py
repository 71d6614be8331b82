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
    """RMS in rad between what robot.py of a folder and t2l predict of recordings.

    Args:
        folder: that was exported with the gains of `recordings`, which all have the same.
    """
    predictor = Predictor(model.robot, recordings, threads=1)
    ours = predictor.predict([Request(layout, u[None])])[0][0]
    lead_s = json.loads((folder / "export.json").read_text())["log_lead_s"]
    theirs = predictor.samples.of([replay(folder, each, lead_s) for each in recordings])
    return float(np.sqrt(np.nanmean((theirs - ours) ** 2)))


def replay(folder: Path, recording: Recording, lead_s: float = 0.0) -> np.ndarray:
    """Positions (n, njoint) at a recording's rows of the robot that a folder holds, rad.

    Args:
        lead_s: by how much commands are in force before their time.
    """
    spec = importlib.util.spec_from_file_location("exported_robot", folder / "robot.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    robot = module.Robot()
    elapsed = recording.time - recording.time[0]
    ticks = np.arange(int(np.ceil(elapsed[-1] / robot.period_s)) + 2)
    commands = _commands(recording, ticks, robot.period_s, lead_s)
    robot.start(*start_state(recording), commands[0])
    q = np.empty((len(ticks), len(recording.joints)))
    for tick in ticks:
        q[tick] = robot.q
        robot.step(commands[tick])
    at = elapsed / robot.period_s
    return np.column_stack([np.interp(at, ticks, column) for column in q.T])


def _commands(
    recording: Recording, ticks: np.ndarray, period_s: float, lead_s: float
) -> np.ndarray:
    """q_des (ntick, njoint) in force, rad; between two ticks it is linear."""
    elapsed = recording.time - recording.time[0]
    row = np.searchsorted(elapsed, ticks * period_s + 1e-6, side="right") - 1
    led = np.minimum(ticks + lead_s / period_s, ticks[-1])
    columns = recording.q_des[row].T
    return np.column_stack([np.interp(led, ticks, column) for column in columns])
