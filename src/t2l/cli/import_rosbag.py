"""``t2l import-rosbag``: recordings from ROS 2 bags and MCAP files."""

import argparse

from t2l.cli.mapped import add_mapped, import_mapped

HELP = "make recordings of ROS 2 bags or MCAP files"

DESCRIPTION = """\
Make a recording of each bag, a folder of ROS 2 or an .mcap file. A mapping (YAML) says which topics
hold joint states and commands, and what a recording's YAML would say; examples/rosbag_mapping.yaml
is one to start from. It needs the package rosbags (pip install 't2l[ros]'), not ROS.
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Describe the command line."""
    add_mapped(parser, DESCRIPTION, "BAG")


def run(arguments: argparse.Namespace) -> None:
    """See `import_mapped`."""
    from t2l.recordings.importers import read_bag, read_bag_mapping

    import_mapped(arguments, read_bag_mapping, read_bag)
