"""``t2l record``: recordings from an FR3 that aiofranka drives, or from its simulation."""

import argparse
import contextlib
import signal
import sys
from collections.abc import Iterator
from pathlib import Path

from t2l.cli.inputs import add_extensions
from t2l.errors import ConfigurationError

HELP = "record motions of a Franka Research 3, or of aiofranka's simulation of it"

DESCRIPTION = """\
Move a Franka Research 3 by aiofranka at one or more settings of gains and write a recording of
each. CONFIG.yaml says how; examples/record_fr3.yaml is one to start from. All commands are checked
against the limits of positions, velocities and torques before anything moves. Nothing checks for
obstacles: the arm must be able to move freely around its start, and to get there.
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Describe the command line."""
    parser.description = DESCRIPTION
    parser.add_argument("config", type=Path, metavar="CONFIG.yaml")
    parser.add_argument("--out", type=Path, required=True, help="folder for the recordings")
    parser.add_argument("--check", action="store_true", help="check everything, move nothing")
    add_extensions(parser)
    parser.add_argument("--yes", action="store_true", help="do not ask before a real arm moves")


def run(arguments: argparse.Namespace) -> None:
    """Check the configuration, then record.

    Raises:
        RecordingError: the configuration is wrong or the robot stopped; what was recorded before
            is kept.
    """
    from t2l.hardware.plan import SIMULATION, read_plan
    from t2l.hardware.record import needed_bytes, record
    from t2l.outputs import check_space, output_folder
    from t2l.recordings.log import TABLES
    from t2l.registry import python_files

    plan = read_plan(arguments.config)
    names = [setting.name for setting in plan.settings]
    entries = [f"{name}{suffix}" for name in names for suffix in (*TABLES, ".yaml")]
    inputs = [arguments.config, *python_files(arguments.extensions)]
    with output_folder(arguments.out, "t2l record", entries, inputs, force=None, once=True) as out:
        check_space(out, needed_bytes(plan))
        print(
            f"{len(names)} recording{'s' if len(names) > 1 else ''} of {plan.duration_s:.1f} s on "
            f"{plan.address}, within all limits",
            flush=True,
        )
        if arguments.check:
            return
        if plan.address != SIMULATION and not arguments.yes:
            _ask(plan.address)
        with _termination_as_interrupt():
            record(plan, out)


def _ask(address: str) -> None:
    try:
        answer = input(f"The arm at {address} will move. Is it free to? [y/N] ")
    except EOFError:
        raise ConfigurationError(
            "nobody is there to say that the arm may move; allowed: a terminal, or --yes"
        ) from None
    if answer.strip().lower() not in ("y", "yes"):
        sys.exit("nothing was moved")


@contextlib.contextmanager
def _termination_as_interrupt() -> Iterator[None]:
    """Let a request to terminate stop the arm as Ctrl-C does."""

    def interrupt(*_) -> None:
        raise KeyboardInterrupt

    before = signal.signal(signal.SIGTERM, interrupt)
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, before)
