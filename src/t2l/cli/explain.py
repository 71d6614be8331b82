"""``t2l explain``: diagnose and adopt in turn until nothing more is justified."""

import argparse
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from t2l.cli.inputs import add_log_arguments, add_without
from t2l.diagnose.files import EXPLANATION, MODEL

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

QUICK = (
    "an answer in seconds: sets of known effects from one linear model of the loop, the best of "
    "them fitted in full; without curves and without a diagnosis of each step"
)

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
    parser.add_argument("--quick", action="store_true", help=QUICK)


def run(arguments: argparse.Namespace) -> None:
    """Explain, compare before and after, write, and tell the story."""
    from t2l.cli.beforehand import say_what_is_confounded
    from t2l.cli.estimate import say_how_long
    from t2l.cli.inputs import log_output, progress_line, read_inputs
    from t2l.diagnose.evidence import gather
    from t2l.diagnose.ranking import telling
    from t2l.identify.progress import part
    from t2l.identify.step_size import substeps_for
    from t2l.propose.explained import explained

    model, recordings, holdout = read_inputs(arguments)
    if arguments.quick:
        quick(arguments, model, recordings, holdout)
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
    titles = {name: effect.title for name, effect in model.known_effects().items()}
    untold = {entry.effect for entry in explanation.confounded}
    for step in explanation.steps:
        print(
            f"{titles.get(step.effect, 'model as it came'):41s} training "
            f"{1e3 * step.train_rmse_rad:8.4g} mrad, test {1e3 * step.test_rmse_rad:8.4g}"
            f"{_sure(step.chosen_share, step.effect in untold)}"
        )
    print(explanation.sentence)
    print(f"Written to {arguments.out}; open {arguments.out / 'report.html'}")


def quick(
    arguments: argparse.Namespace,
    model: "Model",
    recordings: "Sequence[Recording]",
    holdout: "Sequence[Recording]",
) -> None:
    """Answer by `t2l.detective`; files and page as of the whole explanation."""
    from t2l.cli.inputs import log_output
    from t2l.detective.data_split import split
    from t2l.detective.explanation import check_no_steps, explained_quickly, in_words
    from t2l.diagnose.final_parameters import parameters_of
    from t2l.diagnose.forward_selection import write_explanation
    from t2l.diagnose.measured_torque import torque_sides
    from t2l.identify.step_size import substeps_for

    check_no_steps(arguments.out)
    with log_output(arguments, ENTRIES, model, [*recordings, *holdout]) as out:
        data = split(model.robot, recordings, holdout, substeps_for(model, recordings))
        explanation = explained_quickly(model, data, lambda what: print(what, flush=True))
        rows = parameters_of(explanation.model, data.fitted, data.fitted_mask)
        write_explanation(explanation, out, rows)
        _show(out, model, explanation.model, [*recordings, *holdout])
    print("\n".join(in_words(explanation)))
    for sides in torque_sides(data.fitted):
        print(sides.sentence)
    print(f"Written to {arguments.out}; open {arguments.out / 'report.html'}")


def _show(out: Path, before: "Model", after: "Model", recordings: "Sequence[Recording]") -> None:
    """Compare both models with the recordings, and draw figures and page of what is in `out`."""
    from t2l.diagnose.compare import compare, write
    from t2l.figures.diagnosis import draw_explanation
    from t2l.report import write_report

    for name, which in (("before", before), ("after", after)):
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
