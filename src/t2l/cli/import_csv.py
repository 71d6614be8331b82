"""``t2l import-csv``: recordings from CSV files with columns and units of their own."""

import argparse
from pathlib import Path

from t2l.cli.inputs import add_extensions, add_force

HELP = "make recordings of CSV files whose columns and units a mapping explains"

DESCRIPTION = """\
Make recordings of CSV files with columns and units of their own. A mapping (YAML) says what every
column of the recording comes from, and what a recording's YAML would say; examples/csv_mapping.yaml
is one to start from. Several tables share one mapping.
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Describe the command line."""
    parser.description = DESCRIPTION
    parser.add_argument("mapping", type=Path, metavar="MAPPING.yaml")
    parser.add_argument("tables", type=Path, nargs="+", metavar="TABLE.csv")
    parser.add_argument("--out", type=Path, required=True, help="folder for the recordings")
    parser.add_argument("--kp", type=float, help="stiffness instead of the mapping's, N·m/rad")
    parser.add_argument("--kd", type=float, help="damping instead of the mapping's, N·m·s/rad")
    parser.add_argument("--format", choices=("csv", "parquet"), default="csv")
    add_extensions(parser)
    add_force(parser)


def run(arguments: argparse.Namespace) -> None:
    """Check every table, then write every recording.

    Raises:
        RecordingError: the mapping or a table is wrong; nothing is written.
    """
    from t2l.cli.recordings import write_recordings
    from t2l.recordings.importers import read_mapped, read_mapping

    gains = {key: value for key in ("kp", "kd") if (value := getattr(arguments, key)) is not None}
    mapping = read_mapping(arguments.mapping, **gains)
    recordings = [read_mapped(table, mapping) for table in arguments.tables]
    write_recordings(recordings, arguments, [arguments.mapping, *arguments.tables])
