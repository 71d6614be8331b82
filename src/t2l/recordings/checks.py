"""What must hold for a table to be usable: its columns, its numbers, the joints' ranges."""

import logging
import math
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from t2l.errors import RecordingError
from t2l.recordings.control import CONTROLS, MEASURED, POSITION, UNITS, Control
from t2l.recordings.recording import Recording
from t2l.typed import LARGEST, suggestion

logger = logging.getLogger(__name__)

# prefixes of the columns that belong to one joint
COMMANDED = "q_des"
ADDED = ("dq_des", "tau_ff")  # commands beside it
COMMANDS = (COMMANDED, *ADDED)
KINDS = (*COMMANDS, *MEASURED)  # attributes of a recording
# a column without a joint stands for all of them
SHARED = ("supply_voltage", "temperature", "torque_enabled")

LEAST_SAMPLES = 10  # bound: fewer say nothing about a response
LEAST_DURATION_S = 0.2  # bound: likewise

# bound: of the control loop: a simulation of more takes minutes on one core
MOST_TICKS = 10_000_000
# bound: between rows: a thousand and more is a time in ms, a few is a log slower than its commands
MOST_COMMANDS_A_ROW = 100

# bound: of a position: beyond it single precision, which traces and data sets have, tells less than
# 0.01 rad apart
MOST_RAD = 1e5
# bound: beyond its range, that a command may ask for: a controller leads by less than a turn
MOST_LEAD_RAD = 2 * math.pi

# bound: beyond a joint's range: sensors and mechanical stops are this exact
RANGE_TOLERANCE_RAD = 0.05


def check_columns(
    columns: Sequence[str], joints: Sequence[str], path: Path, control: str = POSITION
) -> None:
    """Whether a table has the columns that its joints and its control ask for, and no others.

    Raises:
        RecordingError: a column is missing, unknown, repeated, or there for some joints only.
    """
    if len(columns) == 1 and any(mark in columns[0] for mark in ";\t"):
        raise RecordingError(
            path, "the header", f"one column, {columns[0]!r}", "columns separated by commas"
        )
    by = CONTROLS[control]
    known = ["time", *(f"{kind}.{j}" for kind in by.columns for j in joints), *SHARED]
    for column in columns:
        check_belongs(column, by, control, path, f"column {column}")
        if column not in known:
            raise RecordingError(
                path,
                f"column {column}",
                f"an unknown column{suggestion(column, known)}",
                ", ".join(known),
            )
        if list(columns).count(column) > 1:
            raise RecordingError(path, f"column {column}", "it twice", "each column once")
    if "time" not in columns:
        raise RecordingError(path, "column time", "nothing", "the time of every row, in s")
    for kind in by.columns:
        missing = [joint for joint in joints if f"{kind}.{joint}" not in columns]
        if kind in columns:
            if len(missing) < len(joints):
                raise RecordingError(
                    path, f"column {kind}", "columns of single joints too", "one or the other"
                )
            continue
        optional = is_optional(kind, by)
        if missing and not (optional and len(missing) == len(joints)):
            allowed = f"{kind} of each of the {len(joints)} joints of the YAML, in {UNITS[kind]}"
            if control != POSITION and not optional:
                allowed += f", as control is {control}"
            if optional:
                empty = "" if kind in by.commands else ", with empty cells where not sampled"
                allowed += f"{empty}, or of none"
            raise RecordingError(path, f"column {kind}.{missing[0]}", "nothing", allowed)


def is_optional(column: str, by: Control) -> bool:
    """Whether a table may do without a column of the joints."""
    return column not in (by.command, "q")


def check_belongs(column: str, by: Control, control: str, path: Path, where: str) -> None:
    """Whether a column is no command of another kind of control.

    Raises:
        RecordingError: it is.
    """
    kind = column.partition(".")[0]
    if kind in by.columns or kind not in UNITS:
        return
    kinds = " or ".join(name for name, other in CONTROLS.items() if kind in other.commands)
    raise RecordingError(
        path, where, f"a command of control: {kinds}, where control is {control}",
        f"commands in {', '.join(by.commands)}; or that control in the YAML",
    )  # fmt: skip


def check_samples(recording: Recording) -> Recording:
    """The recording with one row a stamp, if its numbers can be a run of a machine.

    It begins where every joint has been measured. NaN in measured arrays means "not sampled" and
    gaps in time are legal. How many rows were left out, and why, is logged as a warning.

    Raises:
        RecordingError: time that decreases, NaN among the commands, an infinite value, a joint
            without measurements, or too short a recording.
    """
    path = recording.path or recording.name
    _check_time(recording.time, path)
    # before rows are left out, so that errors count the rows of the file
    _check_values(recording, path)
    merged = recording.one_row_a_stamp()
    repeated = len(recording.time) - len(merged.time)
    if repeated:
        logger.warning(
            "%s: %d of %d rows left out, as the next has the same time",
            path, repeated, len(recording.time),
        )  # fmt: skip
    _check_clock(merged, path)
    _check_enough(merged, path)
    return _begun(merged, path)


def _begun(recording: Recording, path: Path | str) -> Recording:
    """From the row on by which every joint has been measured: before, its state is not known."""
    first = np.argmax(~np.isnan(recording.q), axis=0)
    last = int(np.argmax(first))
    if first[last] == 0:
        return recording
    logger.warning(
        "%s: the first %d of %d rows (%.3g s) left out, as column q.%s begins after them",
        path, first[last], len(recording.time), recording.time[first[last]] - recording.time[0],
        recording.joints[last],
    )  # fmt: skip
    begun = recording.from_row(int(first[last]))
    _check_enough(begun, path)
    return begun


def _check_values(recording: Recording, path: Path | str) -> None:
    """Whether every number is finite, or absent where it may be, and of a possible size."""
    for kind in KINDS:
        values = getattr(recording, kind)
        if values is None or kind not in recording.by.columns.values():
            continue
        expected = (len(recording.time), len(recording.joints))
        if values.shape != expected:
            raise RecordingError(
                path,
                f"columns {recording.by.column(kind)}.*",
                f"an array of shape {values.shape}",
                f"{expected}, rows by joints",
            )
        bad = ~np.isfinite(values) if kind in COMMANDS else np.isinf(values)
        if bad.any():
            row, joint = np.argwhere(bad)[0]
            found = "nothing (NaN)" if np.isnan(values[row, joint]) else f"{values[row, joint]}"
            allowed = "a finite number" + ("" if kind in COMMANDS else ", or nothing")
            column = _column(recording, kind, joint)
            raise RecordingError(path, f"row {row + 1}, column {column}", found, allowed)
        most = MOST_RAD if kind in (COMMANDED, "q") else LARGEST
        large = np.abs(values) > most
        if large.any():
            row, joint = np.argwhere(large)[0]
            column = _column(recording, kind, joint)
            raise RecordingError(
                path,
                f"row {row + 1}, column {column}",
                f"{values[row, joint]:g}",
                f"numbers up to {most:g}",
            )
        _check_allowed(kind, values, recording, path)


def _column(recording: Recording, kind: str, joint: int) -> str:
    """What a table calls the column of a quantity of a joint: one may stand for all joints."""
    values = getattr(recording, kind)
    shared = kind in SHARED and np.array_equal(values, values[:, :1] + 0 * values, equal_nan=True)
    return kind if shared else f"{recording.by.column(kind)}.{recording.joints[joint]}"


def _check_allowed(kind: str, values: np.ndarray, recording: Recording, path: Path | str) -> None:
    """Whether switches are 0 or 1, voltages above 0, and temperatures possible."""
    allowed = {
        "torque_enabled": "0 or 1, or nothing",
        "supply_voltage": "above 0 V, or nothing",
        "temperature": "above -273.15 °C, or nothing",
    }
    if kind not in allowed:
        return
    least = {"supply_voltage": 0.0, "temperature": -273.15}  # format: absolute zero
    fine = values > least[kind] if kind in least else np.isin(values, (0, 1))
    bad = ~(fine | np.isnan(values))
    if bad.any():
        row, joint = np.argwhere(bad)[0]
        column = _column(recording, kind, joint)
        found = f"{values[row, joint]:g}"
        raise RecordingError(path, f"row {row + 1}, column {column}", found, allowed[kind])


def _check_time(time: np.ndarray, path: Path | str) -> None:
    bad = ~np.isfinite(time)
    if bad.any():
        row = int(np.argmax(bad))
        found = "nothing (NaN)" if np.isnan(time[row]) else f"{time[row]}"
        raise RecordingError(path, f"row {row + 1}, column time", found, "a finite number, in s")
    bad = np.diff(time) < 0
    if bad.any():
        row = int(np.argmax(bad)) + 1
        raise RecordingError(
            path,
            f"row {row + 1}, column time",
            f"{time[row]:.9g}",
            f"at least the {time[row - 1]:.9g} s of the row before",
        )


def _check_clock(recording: Recording, path: Path | str) -> None:
    """Whether the times go with the rates, so that they are in seconds."""
    if len(recording.time) < 2:
        return
    period = float(np.median(np.diff(recording.time)))
    if period * recording.command_rate_hz > MOST_COMMANDS_A_ROW:
        raise RecordingError(
            path,
            "column time",
            f"a row every {period:.4g} s, where commands come {recording.command_rate_hz:g} "
            "times a second (command_rate_hz)",
            f"at most {MOST_COMMANDS_A_ROW} commands a row (is time in seconds?)",
        )
    check_ticks(recording.duration_s, recording.control_rate_hz, path, "column time")


def check_ticks(duration_s: float, control_rate_hz: float, path: Path | str, where: str) -> None:
    """Whether a recording is short enough to be simulated.

    Raises:
        RecordingError: it is not.
    """
    ticks = duration_s * control_rate_hz
    if ticks > MOST_TICKS:
        raise RecordingError(
            path,
            where,
            f"{duration_s:.4g} s, {ticks:.3g} ticks of a control loop of {control_rate_hz:g} Hz "
            "(control_rate_hz)",
            f"at most {MOST_TICKS:.0e} ticks (is time in seconds?); cut the recording where it "
            "is longer",
        )


def _check_enough(recording: Recording, path: Path | str) -> None:
    sampled = ~np.isnan(recording.q)
    for joint, column in zip(recording.joints, sampled.T, strict=True):
        count = int(column.sum())
        if count < LEAST_SAMPLES:
            found = f"{count} measured positions" if count else "no measured position"
            raise RecordingError(
                path, f"column q.{joint}", found, f"at least {LEAST_SAMPLES} for every joint"
            )
        times = recording.time[column]
        if times[-1] - times[0] < LEAST_DURATION_S:
            raise RecordingError(
                path,
                f"column q.{joint}",
                f"measurements over {times[-1] - times[0]:.3g} s",
                f"at least {LEAST_DURATION_S} s (is time in seconds?)",
            )


def check_against_joint_ranges(
    recording: Recording,
    ranges: np.ndarray,
    names: Sequence[str],
    tolerance_rad: float = RANGE_TOLERANCE_RAD,
) -> None:
    """Whether commanded and measured positions are ones that the model's joints can take.

    Args:
        recording: any recording that was read.
        ranges: rad, (len(names), 2), lower and upper limit; infinite for an unlimited joint.
        names: the model's joints, in the order of `ranges`.
        tolerance_rad: how far outside a position may be.

    Raises:
        RecordingError: a joint is not the model's, or positions are outside its range, with a
            word about degrees if that explains them.
    """
    path = recording.path or recording.name
    names = list(names)
    for joint in recording.joints:
        if joint not in names:
            where = path.with_suffix(".yaml") if isinstance(path, Path) else path
            raise RecordingError(
                where,
                "key joints",
                f"{joint}, which the model does not have{suggestion(joint, names)}",
                ", ".join(names),
            )
    ranges = np.asarray(ranges, dtype=float)
    if ranges.shape != (len(names), 2):
        raise ValueError(f"{len(names)} joints have ranges of shape {ranges.shape}")
    limits = ranges[[names.index(joint) for joint in recording.joints]]
    low, high = limits[:, 0] - tolerance_rad, limits[:, 1] + tolerance_rad
    for kind in (COMMANDED, "q"):
        values = getattr(recording, kind)
        # comparisons with NaN are false: what was not sampled is not outside
        outside = (values < low) | (values > high)
        if kind == COMMANDED:
            outside &= recording.kp > 0  # else nothing follows it
        if not outside.any():
            continue
        row, joint = np.argwhere(outside)[0]
        value = values[row, joint]
        found = f"{value:.6g} rad"
        beyond = np.max(np.maximum(low - values, values - high)[outside])
        in_degrees = np.deg2rad(values)
        fits = not ((in_degrees < low) | (in_degrees > high)).any()
        if fits and beyond > math.pi:
            found = f"{value:.6g}, which looks like degrees ({np.deg2rad(value):.4g} rad)"
        lower, upper = limits[joint]
        raise RecordingError(
            path,
            f"row {row + 1}, column {kind}.{recording.joints[joint]}",
            found,
            f"{lower:.6g} to {upper:.6g} rad, the joint's range in the model",
        )
