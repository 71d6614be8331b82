"""Recordings and the model so far, read and checked together."""

import hashlib
import logging
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from t2l.effects.registry import load as load_effects
from t2l.errors import RecordingError
from t2l.identify.loop_stability import check_settles
from t2l.identify.model import Model, check_joints, read_model
from t2l.identify.units import questions
from t2l.recordings.checks import check_against_joint_ranges
from t2l.recordings.log import read_recordings
from t2l.recordings.motion import check_motion
from t2l.recordings.recording import Recording
from t2l.registry import python_files
from t2l.robots import plant
from t2l.robots.couplings import couplings

logger = logging.getLogger(__name__)


def read_recordings_and_model(
    logs: Sequence[Path],
    holdout: Sequence[Path] = (),
    model_path: Path | None = None,
    effect_files: Sequence[Path] = (),
    aside: str = "--holdout",
) -> tuple[Model, list[Recording], list[Recording]]:
    """The model so far, the recordings, and those to hold out.

    Args:
        model_path: a model file; without it the robot of the first recording as its MJCF says.
        effect_files: files or folders with effects of the user's own; only they may run where the
            model names such files.
        aside: the option that names those to hold out, for messages.

    Raises:
        T2LError: a file is wrong, the recordings do not belong together or do not fit the robot.
    """
    recordings = read_recordings(logs)
    held = read_recordings(holdout) if holdout else []
    files = tuple(Path(path).resolve() for path in effect_files)
    load_effects(files)
    model = Model(recordings[0].robot, {}, files)
    if model_path is not None:
        given = read_model(model_path, trusted=python_files(files))
        model = replace(given, effect_files=(*given.effect_files, *files))
    check_recordings_and_model(model, model_path, recordings, held, aside)
    return model, recordings, held


def check_worth_fitting(
    model: Model, recordings: Sequence[Recording], holdout: Sequence[Recording] = ()
) -> None:
    """Find what no fit can make sense of, before one takes long.

    Raises:
        RecordingError: nothing moves in the recordings.
        ConfigurationError: the model's loop chatters.
    """
    check_motion(recordings)
    check_settles(model, [*recordings, *holdout])


def check_recordings_and_model(
    model: Model,
    model_path: Path | None,
    recordings: Sequence[Recording],
    holdout: Sequence[Recording] = (),
    aside: str = "--holdout",
) -> None:
    """Check what needs the model or more than one recording.

    Raises:
        RecordingError: another robot or other joints than the first recording's, a recording that
            is both fitted and held out, an unknown joint, or commands outside the joint range.
        ConfigurationError: the robot cannot be loaded, or the model names unknown joints.
    """
    first = recordings[0]
    for recording in (*recordings, *holdout):
        if recording.joints != first.joints:
            raise RecordingError(
                recording.path, "joints", ", ".join(recording.joints),
                f"those of {first.path}: {', '.join(first.joints)}",
            )  # fmt: skip
    _check_one_robot((*recordings, *holdout))
    given = {_resolved(recording.path) for recording in recordings}
    measured: dict[bytes, Recording] = {}
    for recording in recordings:
        other = measured.setdefault(_measured(recording), recording)
        if other is not recording:
            logger.warning("%s: holds the measurements of %s", recording.path, other.path)
    for recording in holdout:
        if _resolved(recording.path) in given:
            raise RecordingError(
                recording.path, aside, "a recording that is also given as LOG",
                f"each either as LOG or under {aside}",
            )  # fmt: skip
        # a copy under another name judges itself too; one in memory is nobody's file
        other = measured.get(_measured(recording))
        if other is not None and other.path is not None and recording.path is not None:
            raise RecordingError(
                recording.path, aside, f"the measurements of {other.path}",
                f"each either as LOG or under {aside}",
            )  # fmt: skip
    names = [joint.name for joint in plant.scalar_joints(model.robot)]
    for recording in (*recordings, *holdout):
        unknown = [name for name in recording.joints if name not in names]
        if unknown:
            raise RecordingError(
                recording.path, "joints", ", ".join(unknown),
                f"hinges and slides of {model.robot}: {', '.join(names)}",
            )  # fmt: skip
    compiled = plant.compiled(plant.load(model.robot, first.joints), model.robot)
    for joint in plant.free_joints(model.robot):
        logger.warning(
            "%s: the model floats by its free joint %r; it is held where the MJCF has it, as "
            "recordings say nothing about it", model.robot, joint,
        )  # fmt: skip
    for sentence in couplings(model.robot, first.joints):
        logger.warning("%s: %s", model.robot, sentence)
    ranges = plant.position_ranges(compiled, first.joints)
    for recording in (*recordings, *holdout):
        check_against_joint_ranges(recording, np.asarray(ranges), first.joints)
    for question in questions(model, (*recordings, *holdout)):
        logger.warning("%s", question)
    if model_path is not None:
        check_joints(model_path, model, first.joints)


def _check_one_robot(recordings: Sequence[Recording]) -> None:
    """By what the MJCF says, not where it lies: a folder may bring a copy of its own."""
    first = recordings[0]
    robots = dict.fromkeys(recording.robot for recording in recordings)
    if len(robots) > 1:
        robots = {
            robot: plant.as_bytes(plant.compiled(plant.load(robot, first.joints), robot))
            for robot in robots
        }
    for recording in recordings:
        if robots[recording.robot] != robots[first.robot]:
            raise RecordingError(
                recording.path, "robot", recording.robot, f"that of {first.path}: {first.robot}"
            )


def _resolved(path: Path | None) -> Path | object:
    # a recording in memory is no other's file
    return object() if path is None else path.resolve()


def _measured(recording: Recording) -> bytes:
    """Its gains, commands and positions; two recordings never have the same noise."""
    commands = (recording.q_des, recording.feed_forward)
    parts = (recording.time, *commands, recording.q, recording.kp, recording.kd)
    return hashlib.sha256(b"".join(part.tobytes() for part in parts)).digest()
