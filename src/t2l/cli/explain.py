"""``t2l explain``: diagnose and adopt in turn until nothing more is justified."""

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
    "on with the step it was in"
)
EXPLAINED = 0.95  # format: of the whole, when only the comparison is left

IN_SECONDS = (
    "an answer in seconds: sets of known effects from one linear model of the loop, the best of "
    "them fitted in full; without curves and without a diagnosis of each step"
)

TIME = (
    "with --quick: end with what is found when so many seconds are over; the screening or "
    "fit at hand is finished first"
)
LONGEST_S = 604_800  # bound: of --time, a week

HELP = "diagnose and adopt in turn, and watch the error fall"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Describe the command line."""
    parser.description = (
        "Add one effect after the other, each judged on validation data, until nothing more "
        "is justified. OUT receives explanation.json, model.yaml, the steps and report.html. An "
        "interrupted run goes on with the step it was in. What known effects leave is learned as a "
        "curve, in proposal/."
    )
    add_log_arguments(parser, holdout=True)
    add_without(parser)
    parser.add_argument("--quick", action="store_true", help=IN_SECONDS)
    parser.add_argument("--time", metavar="SECONDS", help=TIME)


def run(arguments: argparse.Namespace) -> None:
    """Explain, compare before and after, write, and tell the story."""
    from t2l.cli.beforehand import say_what_is_confounded
    from t2l.cli.estimate import say_how_long
    from t2l.cli.inputs import log_output, progress_line, read_inputs
    from t2l.diagnose.evidence import gather
    from t2l.diagnose.ranking import telling
    from t2l.identify.progress import part
    from t2l.identify.step_size import substeps_for
    from t2l.names import listed
    from t2l.propose.explained import explained

    over = time_over(arguments)
    model, recordings, holdout = read_inputs(arguments)
    if arguments.quick:
        quick(arguments, model, recordings, holdout, over)
        return
    with log_output(arguments, ENTRIES, model, [*recordings, *holdout]) as out:
        substeps = substeps_for(model, recordings)
        say_how_long(arguments.command, model, recordings, substeps)
        evidence = gather(model.robot, recordings, holdout, substeps)
        evidence = telling(model, evidence)
        beforehand = say_what_is_confounded(model, evidence)
        progress = progress_line()
        explanation = explained(model, evidence, out, part(progress, 0.0, EXPLAINED), beforehand)
        progress("comparing before and after", EXPLAINED)
        _show(out, model, explanation.names, [*recordings, *holdout])
        progress("done", 1.0)
    untold = {entry.effect for entry in explanation.confounded}
    for step in explanation.steps:
        what = listed(step.titles) or "model as it came"
        print(
            f"{what:41s} training "
            f"{1e3 * step.train_rmse_rad:8.4g} mrad, test {1e3 * step.test_rmse_rad:8.4g}"
            f"{_sure(step.chosen_share, not untold.isdisjoint(step.effects))}"
        )
    print(explanation.sentence)
    print(f"Written to {arguments.out}; open {arguments.out / 'report.html'}")


def quick(
    arguments: argparse.Namespace,
    model: "Model",
    recordings: "Sequence[Recording]",
    holdout: "Sequence[Recording]",
    over: "Deadline",
) -> None:
    """Answer by `t2l.detective`; files and page as of the whole explanation."""
    from t2l.cli.estimate import QUICK, say_how_long
    from t2l.cli.inputs import log_output, progress_line, say
    from t2l.detective.data_split import split
    from t2l.detective.explanation import explained_quickly, in_words
    from t2l.detective.kept import check_no_diagnoses
    from t2l.diagnose.measured_torque import torque_sides
    from t2l.identify.progress import part
    from t2l.identify.step_size import substeps_for
    from t2l.report import write_report

    check_no_diagnoses(arguments.out)
    with log_output(arguments, ENTRIES, model, [*recordings, *holdout]) as out:
        substeps = substeps_for(model, recordings)
        data = split(model.robot, recordings, holdout, substeps)
        say_how_long(QUICK, model, data.fitted.recordings, substeps, at_most_s=over.seconds)
        progress = progress_line()
        explanation = explained_quickly(
            model, data, say, part(progress, 0.0, EXPLAINED), over, out,
            written=lambda: write_report(out), began=over.began,
        )  # fmt: skip
        progress("comparing before and after", EXPLAINED)
        _show(out, model, explanation.model, [*recordings, *holdout])
        progress("done", 1.0)
    print("\n".join(in_words(explanation)))
    for sides in torque_sides(data.fitted):
        print(sides.sentence)
    print(f"Written to {arguments.out}; open {arguments.out / 'report.html'}")


@dataclass(frozen=True)
class Deadline:
    """Whether the seconds since some time of the monotonic clock are over; never if None."""

    began: float
    seconds: float | None = None

    def __call__(self) -> bool:
        """Whether they are."""
        return self.seconds is not None and time.monotonic() - self.began >= self.seconds


def time_over(arguments: argparse.Namespace) -> Deadline:
    """What --time says, from now on.

    Raises:
        ConfigurationError: it is no time, or the search does not know it.
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
    if not arguments.quick:
        raise ConfigurationError(f"--time: found {describe(given)}; allowed: with --quick only")
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


def _sure(share: float | None, untold: bool) -> str:
    if share is None:
        return ", not told from other effects" if untold else ""
    from t2l.diagnose.settings import CERTAIN

    uncertain = "" if share >= CERTAIN else ", uncertain"
    uncertain = ", but not told from other effects" if untold else uncertain
    return f", chosen in {100 * share:.0f} % of resamples{uncertain}"
