"""What the commands share that make recordings of files which a mapping explains."""

import argparse
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from t2l.cli.inputs import add_extensions, add_force

if TYPE_CHECKING:
    from t2l.recordings import Recording


def add_mapped(parser: argparse.ArgumentParser, description: str, file: str) -> None:
    """Describe the command line; `file` is what a file is called in it."""
    parser.description = description
    parser.add_argument("mapping", type=Path, metavar="MAPPING.yaml")
    parser.add_argument("files", type=Path, nargs="+", metavar=file)
    parser.add_argument("--out", type=Path, required=True, help="folder for the recordings")
    parser.add_argument("--kp", type=float, help="stiffness instead of the mapping's, N·m/rad")
    parser.add_argument("--kd", type=float, help="damping instead of the mapping's, N·m·s/rad")
    parser.add_argument("--format", choices=("csv", "parquet"), default="csv")
    add_extensions(parser)
    add_force(parser)


def import_mapped(
    arguments: argparse.Namespace,
    read_mapping: Callable[..., Any],
    read_file: Callable[[Path, Any], "Recording"],
) -> None:
    """Check every file, then write every recording.

    Raises:
        RecordingError: the mapping or a file is wrong; nothing is written.
    """
    from t2l.cli.recordings import write_recordings

    gains = {key: value for key in ("kp", "kd") if (value := getattr(arguments, key)) is not None}
    mapping = read_mapping(arguments.mapping, **gains)
    recordings = [read_file(file, mapping) for file in arguments.files]
    write_recordings(recordings, arguments, [arguments.mapping, *arguments.files])
