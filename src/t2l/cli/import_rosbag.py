"""``t2l import-rosbag``: recordings from ROS 2 bags and MCAP files."""

import argparse
from pathlib import Path

from t2l.cli.inputs import add_extensions, add_force

HELP = "make recordings of ROS 2 bags or MCAP files"

DESCRIPTION = """\
Make a recording of each bag, a folder of ROS 2 or an .mcap file. A mapping (YAML) says which topics
hold joint states and commands, and what a recording's YAML would say; examples/rosbag_mapping.yaml
is one to start from. It needs the package rosbags (pip install 't2l[ros]'), not ROS.
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Describe the command line."""
    parser.description = DESCRIPTION
    parser.add_argument("mapping", type=Path, metavar="MAPPING.yaml")
    parser.add_argument("bags", type=Path, nargs="+", metavar="BAG")
    parser.add_argument("--out", type=Path, required=True, help="folder for the recordings")
    parser.add_argument("--kp", type=float, help="stiffness instead of the mapping's, N·m/rad")
    parser.add_argument("--kd", type=float, help="damping instead of the mapping's, N·m·s/rad")
    parser.add_argument("--format", choices=("csv", "parquet"), default="csv")
    add_extensions(parser)
    add_force(parser)


def run(arguments: argparse.Namespace) -> None:
    """Check every bag, then write every recording.

    Raises:
        RecordingError: the mapping or a bag is wrong; nothing is written.
    """
    from t2l.cli.recordings import write_recordings
    from t2l.recordings.importers import read_bag, read_bag_mapping

    gains = {key: value for key in ("kp", "kd") if (value := getattr(arguments, key)) is not None}
    mapping = read_bag_mapping(arguments.mapping, **gains)
    recordings = [read_bag(bag, mapping) for bag in arguments.bags]
    write_recordings(recordings, arguments, [arguments.mapping, *arguments.bags])
