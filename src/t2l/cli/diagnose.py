"""``t2l diagnose``: which physical effect a model lacks."""

import argparse

from t2l.cli.beforehand import ENTRY as BEFOREHAND
from t2l.cli.inputs import add_log_arguments
from t2l.diagnose.files import DIAGNOSIS

ENTRIES = (DIAGNOSIS, BEFOREHAND, "models/", "figures/", "report.html")

HELP = "fit every known effect alone and judge each on what is left out"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Describe the command line."""
    parser.description = (
        "Fit the model so far plus each known effect to LOG, and judge by what is left out of the "
        "fit in turn. The error is told of others: of --holdout, or of recordings or blocks of "
        "time that are chosen from LOG. OUT receives diagnosis.json, models/ with each effect "
        "adopted, and report.html."
    )
    add_log_arguments(parser, holdout=True)


def run(arguments: argparse.Namespace) -> None:
    """Diagnose, write, and say what is missing."""
    from t2l.cli.beforehand import say_what_cannot_be_told, say_what_is_confounded
    from t2l.cli.estimate import say_how_long
    from t2l.cli.inputs import log_output, progress_line, read_inputs
    from t2l.detective.data_split import split
    from t2l.detective.ranking import diagnose
    from t2l.diagnose.artefacts import write_diagnosis
    from t2l.figures.diagnosis import draw_diagnosis
    from t2l.identify.step_size import substeps_for
    from t2l.report import write_report

    model, recordings, holdout = read_inputs(arguments)
    with log_output(arguments, ENTRIES, model, [*recordings, *holdout]) as out:
        substeps = substeps_for(model, recordings)
        say_how_long(arguments.command, model, recordings, substeps)
        say_what_cannot_be_told(model, [*recordings, *holdout], out)
        data = split(model.robot, recordings, holdout, substeps)
        beforehand = say_what_is_confounded(model, data.fitted, data.fitted_mask)
        progress = progress_line()
        diagnosis = diagnose(model, data, progress, beforehand)
        content = write_diagnosis(diagnosis, data.fitted, data.test, out, beforehand)
        draw_diagnosis(out)
        write_report(out)
        progress("done", 1.0)
    print(content["sentence"])
    for entry in content["ranking"][:3]:
        print(f"  {entry['effect']}: {entry['why']}")
    for sentence in content["remaining"]:
        print(f"  {sentence}")
    if content["separating_experiment"]:
        print(f"To tell them apart: {content['separating_experiment']['sentence']}")
    print(f"Written to {arguments.out}; open {arguments.out / 'report.html'}")
