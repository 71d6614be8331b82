"""Recordings from CSV files with columns and units of their own, by a mapping.

A mapping is a YAML with the keys of a recording's YAML and a section `columns`, which says where
every column of the recording comes from:

    columns:
      time: {from: stamp, unit: ms}
      q_des: {from: [cmd_0, cmd_1], unit: deg, sign: [1, -1]}
      q.shoulder: {from: pos_0, unit: deg, offset: 0.01}
      q.elbow: {from: pos_1, unit: deg, sign: -1}

A quantity of all joints takes a list of columns, one for each joint, and one joint's takes one.
`supply_voltage`, `temperature` and `torque_enabled` may take one column for all joints.
A number becomes ``sign · scale · number · unit + offset``, with the offset in SI and radians.
Time is shifted to begin at zero.
"""

import csv
import re
from collections.abc import Mapping as AnyMapping
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Field

from t2l.documents import check_regular, read_yaml
from t2l.errors import RecordingError
from t2l.recordings.checks import SHARED, check_belongs, check_samples, is_optional
from t2l.recordings.control import CONTROLS, Control
from t2l.recordings.importers.units import FACTORS
from t2l.recordings.keys import checked
from t2l.recordings.metadata import Metadata
from t2l.recordings.motor import in_newton_metres
from t2l.recordings.per_joint import per_joint
from t2l.recordings.recording import Recording
from t2l.typed import Switch, Typed, describe, suggestion


class MappingFile(Metadata):
    """A mapping as it is written: a recording's YAML, and where its columns come from."""

    columns: Annotated[dict[str, Any], Field(description=f"the keys {', '.join(FACTORS)}")]
    separator: Annotated[str, Field(min_length=1, max_length=10)] = ","
    decimal: Literal[".", ","] = "."
    held_commands: Switch = False


class ColumnFile(Typed):
    """One entry of `columns` as it is written."""

    source: Annotated[
        Any, Field(alias="from", description="the name of a column of the CSV, or one a joint")
    ]
    unit: str | None = None
    sign: per_joint() = Field(None)
    scale: per_joint() = Field(None)
    offset: per_joint() = Field(None)


@dataclass(frozen=True)
class Source:
    """Where one column of a recording comes from: ``factor · column + offset``, in SI."""

    column: str
    factor: float
    offset: float


@dataclass(frozen=True)
class Mapping:
    """A checked mapping file.

    Attributes:
        path: the mapping file.
        metadata: keyword arguments of `Recording`.
        sources: by column of the recording, such as `time` or `q.shoulder`.
        separator: between cells.
        decimal: the decimal mark.
        held_commands: an empty command means that the one before still holds.
    """

    path: Path
    metadata: AnyMapping[str, Any]
    sources: AnyMapping[str, Source]
    separator: str
    decimal: str
    held_commands: bool


def read_mapping(path: Path | str, **overrides: Any) -> Mapping:
    """Read and check a mapping file.

    Args:
        path: the YAML.
        overrides: values that replace keys of the file, such as ``kp=64``.

    Raises:
        RecordingError: a key is missing, unknown or wrong, or a column has no source.
    """
    path = Path(path)
    values = read_yaml(path, "a mapping, which says what each column of the recording comes from")
    if isinstance(values, dict):
        values = {**values, **overrides}
    found = checked(MappingFile, values, path)
    if found.separator == found.decimal:
        raise RecordingError(
            path, "key decimal", describe(found.decimal), "another mark than the separator"
        )
    return Mapping(
        path=path,
        metadata=found.arguments(path),
        sources=_sources(found, path),
        separator=found.separator,
        decimal=found.decimal,
        held_commands=found.held_commands,
    )


def read_mapped(table: Path | str, mapping: Mapping) -> Recording:
    """The recording that a mapping makes of a CSV file.

    Raises:
        RecordingError: a column or number is missing or wrong, or the result is no recording.
    """
    table = Path(table)
    columns = _read_columns(table, mapping)
    if mapping.held_commands:
        columns = _hold_commands(columns, CONTROLS[mapping.metadata["control"]])
    time = columns["time"]

    def signal(kind: str) -> np.ndarray | None:
        names = [f"{kind}.{joint}" for joint in mapping.metadata["joints"]]
        return np.stack([columns[n] for n in names], axis=1) if names[0] in columns else None

    by = CONTROLS[mapping.metadata["control"]]
    signals = {attribute: signal(column) for column, attribute in by.columns.items()}
    recording = Recording(
        name=table.stem,
        path=table,
        time=time - time[0] if len(time) else time,
        **in_newton_metres(signals, mapping.metadata, table),
    )
    try:
        return check_samples(recording)
    except RecordingError as error:
        where = f"{error.where}, as mapped by {mapping.path}"
        raise RecordingError(table, where, error.found, error.allowed) from None


def _sources(found: MappingFile, path: Path) -> dict[str, Source]:
    joints = found.joints
    by = CONTROLS[found.control]
    known = ["time", *by.columns, *(f"{kind}.{joint}" for kind in by.columns for joint in joints)]
    sources: dict[str, Source] = {}
    for key, value in found.columns.items():
        check_belongs(key, by, found.control, path, f"key columns.{key}")
        if key not in known:
            shown = f"an unknown key{suggestion(key, known)}"
            raise RecordingError(path, f"key columns.{key}", shown, ", ".join(known))
        kind = next(k for k in FACTORS if key == k or key.startswith(f"{k}."))
        targets = [f"{kind}.{joint}" for joint in joints] if key in by.columns else [key]
        # text alone names a column that is in SI already
        value = {"from": value} if isinstance(value, str | list) else value
        each = _each_source(value, path, f"columns.{key}.", kind, len(targets))
        for target, source in zip(targets, each, strict=True):
            if target in sources:
                raise RecordingError(
                    path, f"key columns.{key}", f"a second source of {target}", "one"
                )
            sources[target] = source
    _check_complete(sources, joints, by, path)
    return sources


def _each_source(value: Any, path: Path, prefix: str, kind: str, count: int) -> list[Source]:
    part = checked(ColumnFile, value, path, prefix, context=count)

    def refused(key: str, found: Any, allowed: str) -> RecordingError:
        return RecordingError(path, f"key {prefix}{key}", describe(found), allowed)

    units = FACTORS[kind]
    unit = part.unit or next(iter(units))
    if unit not in units:
        shown = f"{describe(unit)}{suggestion(unit, list(units))}"
        raise RecordingError(path, f"key {prefix}unit", shown, ", ".join(units))
    sign = np.ones(count) if part.sign is None else part.sign
    if not np.isin(sign, (-1, 1)).all():
        raise refused("sign", value["sign"], "1 or -1")
    scale = np.ones(count) if part.scale is None else part.scale
    if (scale == 0).any():
        raise refused("scale", value["scale"], "a number other than 0")
    offset = np.zeros(count) if part.offset is None else part.offset
    names = part.source
    shared = kind in SHARED and isinstance(names, str)
    # a robot with one joint may list it as well
    if (count == 1 or shared) and isinstance(names, str) and names:
        names = [names] * count
    fine = isinstance(names, list) and all(isinstance(n, str) and n for n in names)
    if not fine or (len(set(names)) < len(names) and not shared):
        allowed = "a list of different columns of the CSV" if count > 1 else "a column of the CSV"
        raise refused("from", names, allowed)
    if len(names) != count:
        raise RecordingError(
            path, f"key {prefix}from", f"{len(names)} columns", f"{count}, one for each joint"
        )
    return [
        Source(name, float(g * s * units[unit]), float(o))
        for name, g, s, o in zip(names, sign, scale, offset, strict=True)
    ]


def _check_complete(sources: AnyMapping, joints: tuple[str, ...], by: Control, path: Path) -> None:
    if "time" not in sources:
        raise RecordingError(path, "key columns.time", "nothing", "the column that holds the time")
    for kind in by.columns:
        missing = [joint for joint in joints if f"{kind}.{joint}" not in sources]
        optional = is_optional(kind, by)
        if missing and not (optional and len(missing) == len(joints)):
            raise RecordingError(
                path,
                f"key columns.{kind}.{missing[0]}",
                "nothing",
                f"a source of {kind} for every joint",
            )


def _read_columns(table: Path, mapping: Mapping) -> dict[str, np.ndarray]:
    """Every column of the recording, in SI, NaN where empty."""
    import pandas as pd

    check_regular(table, RecordingError)
    try:
        # as text: only so can a cell that is no number be named
        cells = pd.read_csv(
            table,
            sep=mapping.separator,
            dtype=str,
            keep_default_na=False,
            skipinitialspace=True,
            encoding="utf-8-sig",
            engine="c" if len(mapping.separator) == 1 else "python",
        )
    except FileNotFoundError:
        raise RecordingError(table, "the file", "nothing", "a CSV file") from None
    # pandas' own parser knows csv.Error, and regular expressions re.error
    except (ValueError, OSError, csv.Error, re.error) as error:
        reason = " ".join(str(error).split())
        raise RecordingError(table, "the file", f"what is not CSV ({reason})", "CSV") from None
    if not isinstance(cells.index, pd.RangeIndex):
        raise RecordingError(
            table, "row 1", "more cells than the header has", "as many as in the header"
        )
    cells.columns = [str(name).strip() for name in cells.columns]
    if not cells.columns.is_unique:
        twice = cells.columns[cells.columns.duplicated()][0]
        raise RecordingError(table, f"column {twice}", "it twice", "each column once")
    return {
        target: source.factor * _numbers(cells, source.column, table, mapping) + source.offset
        for target, source in mapping.sources.items()
    }


def _numbers(cells: Any, column: str, table: Path, mapping: Mapping) -> np.ndarray:
    import pandas as pd

    known = list(cells.columns)
    if column not in known:
        raise RecordingError(
            table,
            f"column {column}, which {mapping.path} names",
            f"nothing{suggestion(column, known)}",
            f"one of {', '.join(known)}",
        )
    # a short row leaves None
    texts = cells[column].fillna("").str.strip()
    numbers = pd.to_numeric(texts.str.replace(mapping.decimal, "."), errors="coerce")
    bad = numbers.isna() & ~texts.str.lower().isin(("", "nan"))
    if bad.any():
        row = int(np.argmax(bad))
        raise RecordingError(
            table,
            f"row {row + 1}, column {column}",
            repr(texts[row]),
            f"a number with the decimal mark {mapping.decimal!r}, or nothing where not sampled",
        )
    return numbers.to_numpy(dtype=float)


def _hold_commands(columns: dict[str, np.ndarray], by: Control) -> dict[str, np.ndarray]:
    """Each empty command replaced by the one before; rows before the first ones left out."""
    held = dict(columns)
    first = 0
    for name, values in columns.items():
        if name.partition(".")[0] not in by.commands:
            continue
        given = np.where(np.isnan(values), -1, np.arange(len(values)))
        last = np.maximum.accumulate(given)
        held[name] = np.where(last >= 0, values[last], np.nan)
        first = max(first, int(np.argmax(last >= 0)))
    return {name: values[first:] for name, values in held.items()}
