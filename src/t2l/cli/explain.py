"""``t2l explain``: what a model lacks, until nothing more earns its place."""

import argparse
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from t2l.cli.inputs import add_log_arguments, add_without
from t2l.diagnose.files import AFTER, BEFORE, EXPLANATION, MODEL

if TYPE_CHECKING:
    from t2l.identify.model import Model
    from t2l.recordings.recording import Recording

ENTRIES = (
    EXPLANATION, MODEL, "steps/", "proposal/", "before/", "after/", "figures/", "report.html",
)  # fmt: skip

RESUME = (
    "finished steps are kept, each with its model.yaml, in steps/ of --out; the same command goes "
    "on with the round it was in"
)
EXPLAINED = 0.95  # format: of the whole, when only the comparison is left

TIME = (
    "end with what is found when so many seconds are over; the screening or "
    "fit at hand is finished first"
)
LONGEST_S = 604_800  # bound: of --time, a week

HELP = "find what the model lacks, and watch the error fall"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Describe the command line."""
    parser.description = (
        "Find the effects and curves that the model lacks. Sets of them are screened in a linear "
        "model of the loop, the best are fitted in full, and those are added that lower the error "
        "on what is left out of the fit; then again, until nothing more does. OUT receives "
        "explanation.json, model.yaml, the steps, the curves in proposal/ and report.html. An "
        "interrupted run goes on with the round it was in."
    )
    add_log_arguments(parser, holdout=True)
    add_without(parser)
    parser.add_argument("--time", metavar="SECONDS", help=TIME)


def run(arguments: argparse.Namespace) -> None:
    """Explain, compare before and after, write, and tell the story."""
    from t2l.cli.estimate import say_how_long
    from t2l.cli.inputs import log_output, progress_line, read_inputs, say
    from t2l.detective.data_split import split
    from t2l.detective.explanation import explained, in_words
    from t2l.diagnose.measured_torque import torque_sides
    from t2l.identify.model import read_again
    from t2l.identify.progress import part
    from t2l.identify.step_size import substeps_for
    from t2l.report import write_report

    deadline = deadline_of(arguments)
    model, recordings, holdout = read_inputs(arguments)
    with log_output(arguments, ENTRIES, model, [*recordings, *holdout]) as out:
        substeps = substeps_for(model, recordings)
        data = split(model.robot, recordings, holdout, substeps)
        say_how_long(
            arguments.command, model, data.fitted.recordings, substeps, at_most_s=deadline.seconds
        )
        progress = progress_line()
        explanation = explained(
            model, data, say, part(progress, 0.0, EXPLAINED), deadline, out,
            written=lambda: write_report(out), began=deadline.began,
        )  # fmt: skip
        progress("comparing before and after", EXPLAINED)
        # as its file holds it, so that a comparison with the file is the same
        final = read_again(out / MODEL, explanation.model)
        _show(out, model, final, [*recordings, *holdout])
        progress("done", 1.0)
    print("\n".join(in_words(explanation)))
    for sides in torque_sides(data.fitted):
        print(sides.sentence)
    print(f"Written to {arguments.out}; open {arguments.out / 'report.html'}")


@dataclass(frozen=True)
class Deadline:
    """How much of some seconds since a time of the monotonic clock is gone; nothing if None."""

    began: float
    seconds: float | None = None

    def __call__(self) -> float:
        """The share, 1 and more when all of them are."""
        return 0.0 if self.seconds is None else (time.monotonic() - self.began) / self.seconds


def deadline_of(arguments: argparse.Namespace) -> Deadline:
    """What --time says, from now on.

    Raises:
        ConfigurationError: it is no time.
    """
    from t2l.errors import ConfigurationError
    from t2l.typed import describe

    began, given = time.monotonic(), arguments.time
    if given is None:
        return Deadline(began)
    allowed = f"seconds, above 0 and up to {LONGEST_S}"
    try:
        seconds = float(given)
    except ValueError:
        seconds = 0.0
    if not 0 < seconds <= LONGEST_S:
        raise ConfigurationError(f"--time: found {describe(given)}; allowed: {allowed}")
    return Deadline(began, seconds)


def _show(out: Path, before: "Model", after: "Model", recordings: "Sequence[Recording]") -> None:
    """Compare both models with the recordings, and draw figures and page of what is in `out`."""
    from t2l.diagnose.compare import compare, write
    from t2l.figures.diagnosis import draw_explanation
    from t2l.report import write_report

    for name, which in ((BEFORE, before), (AFTER, after)):
        write(compare(which, recordings), out / name)
    draw_explanation(out)
    write_report(out)
