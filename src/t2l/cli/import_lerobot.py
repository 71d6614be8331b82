"""``t2l import-lerobot``: recordings from the episodes of a LeRobot data set."""

import argparse
from pathlib import Path

from t2l.cli.dataset import add_dataset_arguments
from t2l.cli.inputs import add_extensions, add_force
from t2l.cli.words import integers, numbers

HELP = "make a recording of each episode of a LeRobot data set"

DESCRIPTION = """\
Make a recording of each episode of a LeRobot data set on disk (format 3): `action` is the commanded
position, `observation.state` the measured one. A data set says nothing about the controller, so the
options do.
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Describe the command line."""
    parser.description = DESCRIPTION
    add_dataset_arguments(parser, "folder for the recordings")
    parser.add_argument(
        "--kp", type=numbers, required=True, help="N·m/rad, one number or one for each joint: 1,2"
    )
    parser.add_argument("--kd", type=numbers, required=True, help="N·m·s/rad, likewise")
    parser.add_argument("--control-rate-hz", type=float, required=True)
    parser.add_argument(
        "--gravity-compensation",
        choices=("yes", "no"),
        required=True,
        help="whether the machine cancels gravity itself",
    )
    parser.add_argument(
        "--command-rate-hz", type=float, help="the data set's frame rate unless given"
    )
    parser.add_argument("--episodes", type=integers, metavar="I,J,...", help="all unless given")
    parser.add_argument("--notes", default="", help="kept with every recording")
    parser.add_argument("--format", choices=("csv", "parquet"), default="csv")
    add_extensions(parser)
    add_force(parser)


def run(arguments: argparse.Namespace) -> None:
    """Check every episode, then write every recording.

    Raises:
        RecordingError: the data set or an option is wrong; nothing is written.
    """
    from t2l.cli.recordings import write_recordings
    from t2l.recordings.importers import read_lerobot
    from t2l.robots import ROBOTS

    known = arguments.robot in ROBOTS.names()
    controller = {
        # paths of a command line are relative to where it is typed
        "robot": arguments.robot if known else str(Path(arguments.robot).resolve()),
        "joints": arguments.joints,
        "kp": arguments.kp,
        "kd": arguments.kd,
        "control_rate_hz": arguments.control_rate_hz,
        "gravity_compensation": arguments.gravity_compensation == "yes",
        "notes": arguments.notes,
    }
    if arguments.command_rate_hz is not None:
        controller["command_rate_hz"] = arguments.command_rate_hz
    recordings = read_lerobot(
        arguments.dataset,
        controller,
        degrees=arguments.degrees,
        action_indices=arguments.action_indices,
        state_indices=arguments.state_indices,
        episodes=arguments.episodes,
    )
    write_recordings(recordings, arguments, [arguments.dataset])
