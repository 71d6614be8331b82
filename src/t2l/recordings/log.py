"""The measurement-log format: NAME.csv or NAME.parquet beside NAME.yaml.

>>> recording = read_recording("recordings/kp64_kd4.csv")
>>> recording.q_des.shape, recording.duration_s

The table has a column `time` [s] and, for every joint of the YAML, `q_des.JOINT` [rad],
`q.JOINT` [rad], if commanded `dq_des.JOINT` [rad/s] and `tau_ff.JOINT` [N·m], and, if recorded,
`dq.JOINT` [rad/s], `tau.JOINT` [N·m] and `current.JOINT` [A]. Under another control than that of
positions the commands are other columns, see `t2l.recordings.control`.
`supply_voltage` [V], `temperature` [°C] and `torque_enabled` (0 or 1) are one column, or one for
each joint. An empty measured cell means that nothing was sampled there.
"""

from collections.abc import Iterable
from pathlib import Path
from typing import Literal

import numpy as np

from t2l.documents import check_regular, read_yaml, to_yaml
from t2l.errors import RecordingError
from t2l.recordings.checks import SHARED, check_columns, check_samples
from t2l.recordings.control import CONTROLS
from t2l.recordings.metadata import as_written, check_metadata
from t2l.recordings.motor import in_newton_metres, of_table
from t2l.recordings.recording import Recording
from t2l.recordings.table import read_numbers

TABLES = (".csv", ".parquet")
PURPOSE = "a YAML beside the table, which says robot, joints, gains"


def read_recording(path: Path | str) -> Recording:
    """Read and check one recording.

    Args:
        path: the table, the YAML, or either without its ending.

    Raises:
        RecordingError: naming the file, the key, row or column, what is there, what is allowed.
    """
    stem = _stem(Path(path))
    table_path, yaml_path = _table(stem), Path(f"{stem}.yaml")
    metadata = check_metadata(read_yaml(yaml_path, PURPOSE), yaml_path)
    joints = metadata["joints"]
    columns, numbers = read_numbers(
        table_path,
        lambda columns: check_columns(columns, joints, table_path, metadata["control"]),
    )
    index = {column: i for i, column in enumerate(columns)}

    def signal(kind: str) -> np.ndarray | None:
        if kind in index:
            return np.repeat(numbers[:, index[kind], None], len(joints), axis=1)
        if f"{kind}.{joints[0]}" not in index:
            return None
        return np.ascontiguousarray(numbers[:, [index[f"{kind}.{joint}"] for joint in joints]])

    by = CONTROLS[metadata["control"]]
    signals = {attribute: signal(column) for column, attribute in by.columns.items()}
    recording = Recording(
        name=stem.name,
        path=table_path,
        time=np.ascontiguousarray(numbers[:, index["time"]]),
        **in_newton_metres(signals, metadata, table_path),
    )
    return check_samples(recording)


def read_recordings(paths: Iterable[Path | str] | Path | str) -> list[Recording]:
    """Read recordings; a folder stands for all in it, by name. Each is read once.

    Raises:
        RecordingError: a recording cannot be used, or a folder has none.
    """
    paths = [paths] if isinstance(paths, Path | str) else paths
    stems: dict[Path, Path] = {}
    for path in map(Path, paths):
        for stem in _stems_in(path) if path.is_dir() else [_stem(path)]:
            stems.setdefault(stem.resolve(), stem)
    return [read_recording(stem) for stem in stems.values()]


def files(path: Path | str) -> list[Path]:
    """The tables and YAMLs that a path names: of one recording, or of all in a folder."""
    path = Path(path)
    if path.is_dir():
        return sorted(p for end in (*TABLES, ".yaml") for p in path.glob(f"[!.]*{end}"))
    stem = _stem(path)
    return [p for end in (*TABLES, ".yaml") if (p := Path(f"{stem}{end}")).is_file()]


def write_recording(
    recording: Recording, path: Path | str, format: Literal["csv", "parquet"] = "csv"
) -> Path:
    """Write a recording's table and YAML, both or neither.

    Args:
        recording: what to write; it is checked as when it is read.
        path: without ending, or with that of the table.
        format: of the table; numbers keep every digit in either.

    Returns:
        The path of the table.

    Raises:
        RecordingError: the recording could not be read back.
    """
    # pandas behind it takes a second to import, and readers do not need it
    from t2l.artefacts import whole

    stem = _stem(Path(path))
    table_path, yaml_path = Path(f"{stem}.{format}"), Path(f"{stem}.yaml")
    metadata = as_written(recording, yaml_path)
    check_metadata(metadata, yaml_path)
    recording = of_table(check_samples(recording))
    for other in TABLES:
        if other != table_path.suffix and Path(f"{stem}{other}").exists():
            raise RecordingError(
                table_path, "the folder", f"{stem.name}{other}", "one table of that name; move it"
            )
    with whole(table_path) as table_draft, whole(yaml_path) as yaml_draft:
        _write_table(recording, table_draft, format)
        yaml_draft.write_text(
            to_yaml(metadata, sort_keys=False, allow_unicode=True, default_flow_style=None)
        )
    return table_path


def _write_table(recording: Recording, path: Path, format: str) -> None:
    import pandas as pd

    columns = {"time": recording.time}
    for kind, attribute in recording.by.columns.items():
        values = getattr(recording, attribute)
        if values is not None and kind in SHARED and _same(values).all():
            columns[kind] = values[:, 0]
        elif values is not None:
            columns |= {f"{kind}.{joint}": values[:, i] for i, joint in enumerate(recording.joints)}
    table = pd.DataFrame(columns)
    if format == "csv":
        table.to_csv(path, index=False)
    else:
        table.to_parquet(path, index=False)


def _same(values: np.ndarray) -> np.ndarray:
    """(n, njoint) whether a joint's value is that of the first."""
    return (values == values[:, :1]) | (np.isnan(values) & np.isnan(values[:, :1]))


def _stem(path: Path) -> Path:
    # not with_suffix: a name such as kp0.5_kd2 has a dot of its own
    for suffix in (*TABLES, ".yaml"):
        if path.name.endswith(suffix) and path.name != suffix:
            return path.with_name(path.name.removesuffix(suffix))
    return path


def _table(stem: Path) -> Path:
    found = [path for suffix in TABLES if (path := Path(f"{stem}{suffix}")).exists()]
    allowed = f"one of {', '.join(stem.name + suffix for suffix in TABLES)}"
    if len(found) != 1:
        there = " and ".join(path.name for path in found) or "neither"
        raise RecordingError(stem, "the table", there, allowed)
    check_regular(found[0], RecordingError)
    return found[0]


def _stems_in(folder: Path) -> list[Path]:
    stems = sorted({_stem(path) for path in files(folder)})
    if not stems:
        raise RecordingError(
            folder, "the folder", "no recording", "at least one NAME.csv or NAME.parquet"
        )
    return stems
