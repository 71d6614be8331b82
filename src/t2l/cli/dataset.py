"""Arguments that commands share which read a LeRobot data set of joint positions."""

import argparse
from pathlib import Path

from t2l.cli.words import integers, words


def add_dataset_arguments(parser: argparse.ArgumentParser, out: str) -> None:
    """DATASET, --out, --robot, and where and in which unit the joints are.

    Args:
        out: what --out is for.
    """
    parser.add_argument("dataset", type=Path, metavar="DATASET", help="folder with meta and data")
    parser.add_argument("--out", type=Path, required=True, help=out)
    parser.add_argument(
        "--robot", required=True, help="a name, or the path of an MJCF or URDF file"
    )
    parser.add_argument(
        "--joints",
        type=words,
        required=True,
        metavar="A,B,...",
        help="the model's joints, found by name in the data set unless indices are given",
    )
    parser.add_argument(
        "--degrees", action="store_true", help="positions and velocities are in degrees"
    )
    parser.add_argument("--action-indices", type=integers, metavar="I,J,...")
    parser.add_argument("--state-indices", type=integers, metavar="I,J,...")
