"""Arguments that compare, diagnose and explain share, read and checked together."""

import argparse
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

import numpy as np

from t2l.errors import ConfigurationError
from t2l.identify.model import Model
from t2l.outputs import output_folder
from t2l.recordings.recording import Recording

LONG_S = 20.0  # format: that a person waits without being told
FIRST_S = 2.0  # format: after which what remains can be told


def add_log_arguments(parser: argparse.ArgumentParser, holdout: bool) -> None:
    """LOG…, --model, --effects, --extensions, --out, and --holdout where it makes sense."""
    parser.add_argument("logs", nargs="+", type=Path, metavar="LOG", help="recording or folder")
    if holdout:
        parser.add_argument(
            "--holdout", action="append", nargs="+", type=Path, default=[], metavar="LOG",
            help="recording or folder to report the error of, for nothing else; may be repeated",
        )  # fmt: skip
    parser.add_argument("--model", type=Path, help="the model so far (default: the MJCF as it is)")
    add_effects(parser)
    add_extensions(parser)
    parser.add_argument("--out", type=Path, required=True, help="folder for what is found")
    add_force(parser)


def add_effects(parser: argparse.ArgumentParser) -> None:
    """--effects and --trust, alike in every command that reads a model."""
    parser.add_argument(
        "--effects", action="append", type=Path, default=[], metavar="FILE",
        help="Python file, or folder of them, with effects of your own; may be repeated",
    )  # fmt: skip
    parser.add_argument(
        "--trust", action="store_true",
        help="run Python files that the model names and --effects does not",
    )  # fmt: skip


def add_without(parser: argparse.ArgumentParser) -> None:
    """--without, for what is not to be found."""
    parser.add_argument(
        "--without", action="append", default=[], metavar="EFFECT",
        help="a known effect that is not to be tried; may be repeated",
    )  # fmt: skip


def add_extensions(parser: argparse.ArgumentParser) -> None:
    """--extensions, alike in every command that reads the name of a robot."""
    parser.add_argument(
        "--extensions", action="append", type=Path, default=[], metavar="FILE",
        help="Python file, or folder of them, with robots of your own; may be repeated",
    )  # fmt: skip


def add_force(parser: argparse.ArgumentParser) -> None:
    """--force, alike in every command that may replace."""
    parser.add_argument(
        "--force", action="store_true", help="replace what is in the way, and say what"
    )


@contextmanager
def log_output(
    arguments: argparse.Namespace,
    entries: Sequence[str],
    model: Model,
    recordings: Sequence[Recording],
) -> Iterator[Path]:
    """Claim --out for a command that reads recordings, none of which it may touch.

    Raises:
        OutputError: the folder is not this command's, or something that is read is in the way.
    """
    from t2l.registry import python_files
    from t2l.robots.plant import files

    tables = [recording.path for recording in recordings if recording.path is not None]
    inputs = [
        *arguments.logs,
        *(path for group in getattr(arguments, "holdout", []) for path in group),
        *tables,
        *(path.with_name(f"{path.name.removesuffix(path.suffix)}.yaml") for path in tables),
        *([arguments.model] if arguments.model else []),
        *python_files((*model.effect_files, *arguments.extensions)),
        *files(model.robot),
    ]
    with output_folder(
        arguments.out, f"t2l {arguments.command}", entries, inputs, arguments.force
    ) as folder:
        yield folder


def read_inputs(
    arguments: argparse.Namespace, fitted: bool = True
) -> tuple[Model, list[Recording], list[Recording]]:
    """The model so far, the recordings, and those to hold out.

    Args:
        fitted: whether something is to be fitted to the recordings.

    Raises:
        T2LError: a file is wrong, the recordings do not belong together or do not fit the robot, or
            the model's loop chatters and is to be fitted.
    """
    from t2l.diagnose.recordings_and_model import (
        check_worth_fitting,
        read_recordings_and_model,
    )

    held = [path for group in getattr(arguments, "holdout", []) for path in group]
    model, recordings, holdout = read_recordings_and_model(
        arguments.logs, held, arguments.model, arguments.effects
    )
    names = tuple(getattr(arguments, "without", ()))
    if names:
        check_without(names, model)
    if fitted:
        check_worth_fitting(model, recordings, holdout)
    return replace(model, without=names), recordings, holdout


def check_without(names: Sequence[str], model: Model) -> None:
    """Find names that cannot be left out.

    Raises:
        ConfigurationError: an unknown effect, or one that the model has.
    """
    from t2l.errors import ConfigurationError
    from t2l.typed import describe, suggestion

    known = model.known_effects()
    for name in names:
        if name not in known:
            raise ConfigurationError(
                f"--without: found {describe(name)}{suggestion(name, list(known))}; allowed: "
                f"{', '.join(sorted(known))}"
            )
        if name in model.effects:
            raise ConfigurationError(
                f"--without: found {name!r}, which the model has; allowed: one that it has not"
            )


def gain_of_each(
    arguments: argparse.Namespace, name: str, joints: Sequence[str], zero: bool = True
) -> np.ndarray:
    """(njoint,) of an option such as --kp, one number or one for each joint.

    Args:
        zero: whether it may be zero.

    Raises:
        ConfigurationError: it is something else.
    """
    given = getattr(arguments, name)
    values = np.atleast_1d(np.array(given, float))
    positive = (values >= 0 if zero else values > 0) & np.isfinite(values)
    if len(values) not in (1, len(joints)) or not positive.all():
        raise ConfigurationError(
            f"--{name.replace('_', '-')}: found {given}; allowed: one number "
            f"{'from 0 up' if zero else 'above 0'}, or one for each of {', '.join(joints)}"
        )
    return np.broadcast_to(values, len(joints)).copy()


def progress_line() -> Callable[[str, float], None]:
    """Report what is being done: one line that is rewritten on a terminal, else a line each.

    The percentage is that of the whole run, and never goes back.
    """
    from t2l.identify.progress import forward

    started, last = time.monotonic(), [""]

    def report(what: str, fraction: float) -> None:
        text = f"{100 * fraction:3.0f} %  {what}"
        if sys.stderr.isatty():
            print(f"\r\033[K{text}", end="\n" if fraction >= 1 else "", file=sys.stderr, flush=True)
        elif what != last[0]:
            print(f"[{time.monotonic() - started:6.1f} s] {text}", file=sys.stderr, flush=True)
        last[0] = what

    return forward(report)


def say(what: str) -> None:
    """Print a line, in place of a line of progress that stands on a terminal."""
    if sys.stderr.isatty():
        print("\r\033[K", end="", file=sys.stderr, flush=True)
    print(what, flush=True)


def long_work(what: str, clock: Callable[[], float] = time.monotonic) -> Callable[[float], None]:
    """Report which part of some work is done, and how long all of it takes, if that is long."""
    line, said, first = progress_line(), [""], []

    def report(part: float) -> None:
        # what comes before the first part is not of the same pace
        if not first:
            first.append((clock(), part))
        began, begun = first[0]
        elapsed, done = clock() - began, part - begun
        if not said[0] and elapsed > FIRST_S and done > 0:
            whole_s = elapsed * (1 - begun) / done
            said[0] = f"{what}, about {whole_s:.0f} s" if whole_s > LONG_S else ""
        if said[0]:
            line(said[0], part)

    return report
