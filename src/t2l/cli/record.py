"""``t2l record``: recordings from a robot, or from a simulation of one."""

import argparse
import contextlib
import signal
import sys
from collections.abc import Iterator
from pathlib import Path

from t2l.cli.inputs import add_extensions
from t2l.errors import ConfigurationError
from t2l.waiting import stopping_itself

RESUME = "motions that were recorded are kept"

HELP = "record motions of a robot, real or virtual"

DESCRIPTION = """\
Move a robot at one or more settings of gains and write a recording of each. CONFIG.yaml says which
robot and how; examples/record_fr3.yaml is one to start from. Before anything moves, commands are
checked against the limits of positions, velocities and torques, and so is what a simulation makes
of them under their gains. While it moves, a joint that is measured beyond a limit stops the robot.
Nothing checks for obstacles: the robot must be able to move freely around its start, and to get
there.
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Describe the command line."""
    parser.description = DESCRIPTION
    parser.add_argument("config", type=Path, metavar="CONFIG.yaml")
    parser.add_argument("--out", type=Path, required=True, help="folder for the recordings")
    parser.add_argument("--check", action="store_true", help="check everything, move nothing")
    add_extensions(parser)
    parser.add_argument("--yes", action="store_true", help="do not ask before a real robot moves")


def run(arguments: argparse.Namespace) -> None:
    """Check the configuration, then record.

    Raises:
        ConfigurationError: the configuration is wrong, or a motion is beyond a limit.
        BackendError: the robot stopped, or was stopped beyond a limit; what was recorded before is
            kept.
    """
    from t2l.hardware.plan import read_plan
    from t2l.hardware.recorder import needed_bytes, record_plan
    from t2l.outputs import check_space, output_folder
    from t2l.recordings.log import TABLES
    from t2l.registry import python_files

    plan = read_plan(arguments.config)
    names = [motion.name for motion in plan.motions]
    moving = plan.backend.moves(plan.settings)
    entries = [f"{name}{suffix}" for name in names for suffix in (*TABLES, ".yaml")]
    inputs = [arguments.config, *python_files(arguments.extensions)]
    with output_folder(arguments.out, "t2l record", entries, inputs, force=None, once=True) as out:
        check_space(out, needed_bytes(plan))
        duration_s = sum(motion.duration_s for motion in plan.motions)
        print(
            f"{len(names)} recording{'s' if len(names) > 1 else ''}, {duration_s:.1f} s in all, of "
            f"{plan.robot.name} through "
            f"{plan.backend.name}, within all limits",
            flush=True,
        )
        if arguments.check:
            return
        if moving and not arguments.yes:
            _ask(moving)
        with stopping_itself(), _termination_as_interrupt():
            record_plan(plan, out)


def _ask(moving: str) -> None:
    try:
        answer = input(f"{moving} will move. Is it free to? [y/N] ")
    except EOFError:
        raise ConfigurationError(
            f"nobody is there to say that {moving} may move; allowed: a terminal, or --yes"
        ) from None
    if answer.strip().lower() not in ("y", "yes"):
        sys.exit("nothing was moved")


@contextlib.contextmanager
def _termination_as_interrupt() -> Iterator[None]:
    """Let a request to terminate stop the robot as Ctrl-C does."""

    def interrupt(*_) -> None:
        raise KeyboardInterrupt

    before = signal.signal(signal.SIGTERM, interrupt)
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, before)
