"""``t2l gains``: the gains that hide in commanded and achieved positions."""

import argparse
from pathlib import Path

from t2l.cli.inputs import add_extensions, add_force
from t2l.cli.words import integers, words

HELP = "find how stiff and how damped a position controller was, from its commands and motion"

DESCRIPTION = """\
Find how each joint answers its position commands: lag, gain and phase, overshoot after steps, and
the second-order response (natural frequency and damping ratio, with 95 % intervals) that a
controller's gains make. DATASET is a LeRobot data set with joint positions as actions, a recording,
or a folder of recordings. No model of the robot is needed.
"""

ENTRIES = ("gains.json", "figures/")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Describe the command line."""
    parser.description = DESCRIPTION
    parser.add_argument("datasets", nargs="+", type=Path, metavar="DATASET")
    parser.add_argument("--joints", type=words, metavar="A,B,...", help="all unless given")
    parser.add_argument(
        "--episodes", type=integers, metavar="I,J,...", help="of a data set; all unless given"
    )
    parser.add_argument(
        "--stiff-from-hz", type=float, default=2.0, metavar="HZ",
        help="natural frequency from which a joint is called stiff (default: 2)",
    )  # fmt: skip
    parser.add_argument("--out", type=Path, help="folder for gains.json and figures")
    add_extensions(parser)
    add_force(parser)


def run(arguments: argparse.Namespace) -> None:
    """Analyse every joint, print the table, write what was found.

    Raises:
        RecordingError: the data set is wrong, or nothing in it is commanded to move.
        OutputError: --out is not this command's.
    """
    from contextlib import nullcontext

    from t2l.errors import ConfigurationError, RecordingError
    from t2l.outputs import output_folder
    from t2l.registry import python_files
    from t2l.response.artefacts import table
    from t2l.response.joints import responses
    from t2l.response.motions import read_motions

    if not 0 < arguments.stiff_from_hz < float("inf"):
        raise ConfigurationError(
            f"--stiff-from-hz: found {arguments.stiff_from_hz:g}; allowed: a number above 0"
        )
    motions = read_motions(arguments.datasets, arguments.joints, arguments.episodes)
    inputs = [*arguments.datasets, *python_files(arguments.extensions)]
    claim = (
        output_folder(arguments.out, "t2l gains", ENTRIES, inputs, arguments.force)
        if arguments.out
        else nullcontext()
    )
    with claim as out:
        found = [
            response for one in motions for response in responses(one, arguments.stiff_from_hz)
        ]
        if not found:
            raise RecordingError(
                arguments.datasets[0], "commands", "no measured joint that is commanded to move",
                "at least one",
            )  # fmt: skip
        if out is not None:
            _write(found, arguments.stiff_from_hz, out)
    print(table(found))
    if arguments.out:
        print(f"Written to {arguments.out}")


def _write(found, stiff_from_hz: float, out: Path) -> None:
    from t2l.figures.joint_responses import response_motions
    from t2l.figures.response_map import response_map
    from t2l.plotting.style import write
    from t2l.response.artefacts import GAINS, write_responses

    write_responses(found, stiff_from_hz, out / GAINS)
    for name, figure in (
        ("map", response_map(found, stiff_from_hz)), ("motions", response_motions(found)),
    ):  # fmt: skip
        write(figure, [out / "figures" / f"{name}.{kind}" for kind in ("pdf", "png")])
