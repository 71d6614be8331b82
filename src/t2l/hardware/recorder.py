"""Recording the motions of a plan, one after another, from whichever robot."""

import tempfile
from collections.abc import Callable
from pathlib import Path

import numpy as np

from t2l.errors import OutputError
from t2l.hardware.backend import BackendError
from t2l.hardware.motion import Motion
from t2l.hardware.plan import Plan
from t2l.names import path_of
from t2l.recordings.log import write_recording
from t2l.recordings.recording import Recording


def record_plan(
    plan: Plan, folder: Path | str, report: Callable[[str], None] = print
) -> list[Path]:
    """Record every motion of a plan; each recording is written when it is complete.

    Whatever ends it, an error or Ctrl-C, the robot is first brought to rest, then released.

    Args:
        plan: a checked plan.
        folder: for the recordings; the caller has claimed it by `t2l.outputs.output_folder`, which
            sees to it that no recording is replaced.
        report: takes a line for each recording.

    Returns:
        The paths of the tables.

    Raises:
        BackendError: the robot cannot be reached, does not go on, or left its limits.
    """
    paths: list[Path] = []
    if moving := plan.backend.moves(plan.settings):
        report(f"connecting to {moving}")
    try:
        with plan.backend.open(plan.robot, plan.settings) as arm:
            for motion in plan.motions:
                recording = arm.record(motion)
                paths.append(write_or_keep(recording, path_of(Path(folder), motion.name)))
                report(f"{paths[-1]}: {_summary(recording, motion)}")
    except BackendError as error:
        raise BackendError(f"{plan.path}: {error}") from error
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
    return sum(25 * (1 + 4 * motion.q_des.shape[1]) * len(motion.q_des) for motion in plan.motions)


def _summary(recording: Recording, motion: Motion) -> str:
    lag = np.nanmax(np.abs(recording.q_des - recording.q))
    text = f"{recording.duration_s:.1f} s, up to {lag:.3f} rad behind"
    used = {row.tobytes() for row in recording.q_des}
    skipped = sum(row.tobytes() not in used for row in motion.q_des)
    if skipped:
        text += f"; the loop was too late for {skipped} of {len(motion.q_des)} commands"
    return text
