"""Recording from an FR3 driven by aiofranka, real or simulated, with the same calls.

For each setting of gains the arm goes to the start, comes to rest under these gains, and follows
the commands of the plan. aiofranka's loop logs every cycle; a row is kept for each command, at the
cycle that first used it, so that the log says when a command acted and not when it was sent.
"""

import tempfile
from collections.abc import Callable
from importlib.metadata import version
from itertools import pairwise
from pathlib import Path

import numpy as np

from t2l.errors import OutputError, RecordingError
from t2l.hardware.franka_arm import CONTROL_RATE_HZ, SIMULATION, FrankaArm, franka_arm
from t2l.hardware.plan import Plan, Setting
from t2l.names import path_of
from t2l.recordings.log import write_recording
from t2l.recordings.recording import Recording

FIELDS = ["time", "q", "dq", "tau", "q_desired"]
TAU = "tau is the torque that was sent, on top of the robot's gravity compensation"


def record(plan: Plan, folder: Path | str, report: Callable[[str], None] = print) -> list[Path]:
    """Record every setting of a plan; each recording is written when it is complete.

    Whatever ends it, an error or Ctrl-C, the arm is first held where it is, then released.

    Args:
        plan: a checked plan.
        folder: for the recordings; the caller has claimed it by `t2l.outputs.output_folder`, which
            sees to it that no recording is replaced.
        report: takes a line for each recording.

    Returns:
        The paths of the tables.

    Raises:
        RecordingError: the robot cannot be reached, its loop stopped, or it left its limits.
    """
    folder = Path(folder)
    if plan.address != SIMULATION:
        report(f"connecting to {plan.address}")
    paths = []
    with franka_arm(plan.address, plan.limits, plan.path) as arm:
        for setting in plan.settings:
            recording = _record_one(arm, plan, setting)
            paths.append(write_or_keep(recording, path_of(folder, setting.name)))
            report(f"{paths[-1]}: {_summary(recording, plan)}")
    return paths


def write_or_keep(recording: Recording, path: Path) -> Path:
    """Write what was recorded; where that fails, keep it in another place and say where."""
    try:
        return write_recording(recording, path)
    except OutputError as error:
        kept = write_recording(recording, Path(tempfile.mkdtemp(prefix="t2l_")) / path.name)
        raise OutputError(f"{error}; the recording is kept as {kept}") from None


def needed_bytes(plan: Plan) -> int:
    """What the recordings of a plan take at most: time, four numbers a joint, 25 characters each.

    A row is written for each command.
    """
    columns = 1 + 4 * plan.q_des.shape[1]
    return 25 * columns * len(plan.q_des) * len(plan.settings)


def _summary(recording: Recording, plan: Plan) -> str:
    lag = np.nanmax(np.abs(recording.q_des - recording.q))
    text = f"{recording.duration_s:.1f} s, up to {lag:.3f} rad behind"
    used = {row.tobytes() for row in recording.q_des}
    skipped = sum(row.tobytes() not in used for row in plan.q_des)
    if skipped:
        text += f"; the loop was too late for {skipped} of {len(plan.q_des)} commands"
    return text


def _record_one(arm: FrankaArm, plan: Plan, setting: Setting) -> Recording:
    arm.approach(plan.q_des[0], setting.kp, setting.kd, setting.name)
    # the loop must never wait for its buffer to be emptied
    with arm.controller.record(FIELDS, seconds=plan.duration_s + 60.0) as cycles:
        arm.follow(plan.q_des, plan.command_rate_hz, setting.name)
    if cycles.dropped:
        raise RecordingError(
            plan.path, setting.name, f"{cycles.dropped} cycles not logged", "none; record it again"
        )
    return _as_recording(cycles.data(), plan, setting)


def _as_recording(cycles: dict[str, np.ndarray], plan: Plan, setting: Setting) -> Recording:
    rows = _rows_of_commands(cycles["q_desired"], round(CONTROL_RATE_HZ / plan.command_rate_hz))
    clock = cycles["time"][rows]
    return Recording(
        name=setting.name,
        path=None,
        robot="fr3",
        joints=plan.limits.joints,
        kp=setting.kp,
        kd=setting.kd,
        command_rate_hz=plan.command_rate_hz,
        control_rate_hz=float(CONTROL_RATE_HZ),
        gravity_compensation=True,
        # cycles are counted in ms; more digits are rounding
        time=np.round(clock - clock[0], 6),
        q_des=cycles["q_desired"][rows],
        q=cycles["q"][rows],
        dq=cycles["dq"][rows],
        tau=cycles["tau"][rows],
        notes=f"{plan.notes}; {TAU}; aiofranka {version('aiofranka')}, {plan.address}",
    )


def _rows_of_commands(q_des: np.ndarray, period: int) -> np.ndarray:
    """Cycles that first used a command, (m,), and others between where one held for long.

    Args:
        q_des: rad, (n, njoint), that each cycle used.
        period: cycles that a command is to hold.
    """
    changes = np.flatnonzero((np.diff(q_des, axis=0) != 0).any(axis=1)) + 1
    edges = [0, *changes.tolist(), len(q_des)]
    rows: list[int] = []
    for begin, end in pairwise(edges):
        # a row too close to the next change would say nothing new
        rows += range(begin, max(begin + 1, end - period // 2), period)
    return np.array(rows)
