"""``t2l propose``: learn what a model lacks as a curve, without any known effect."""

import argparse

from t2l.cli.inputs import add_log_arguments

ENTRIES = ("proposal.json", "models/", "effects/", "figures/", "report.html")

HELP = "learn what no known effect explains, as a curve over one variable"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Describe the command line."""
    parser.description = (
        "Learn the torque that the model so far lacks as a curve over one variable: a joint's own "
        "position, velocity, acceleration, commanded torque, load, time of the recording or the "
        "session, logged temperature or supply voltage, another joint's motion, dry friction "
        "or a limit of the motor torque. It is the search of t2l explain without known effects: "
        "what is left out of the fit in turn chooses, and recordings that are held out report. OUT "
        "receives proposal.json and models/ for t2l adopt, and report.html."
    )
    add_log_arguments(parser, holdout=True)


def run(arguments: argparse.Namespace) -> None:
    """Propose, write, and say what was learned."""
    from t2l.cli.estimate import say_how_long
    from t2l.cli.inputs import log_output, progress_line, read_inputs
    from t2l.detective.data_split import split
    from t2l.detective.explanation import proposed
    from t2l.identify.progress import part
    from t2l.identify.step_size import substeps_for
    from t2l.propose.artefacts import write_proposal
    from t2l.report import write_report

    model, recordings, holdout = read_inputs(arguments)
    with log_output(arguments, ENTRIES, model, [*recordings, *holdout]) as out:
        substeps = substeps_for(model, recordings)
        data = split(model.robot, recordings, holdout, substeps)
        say_how_long(arguments.command, model, data.fitted.recordings, substeps)
        progress = progress_line()
        proposal = proposed(model, data, part(progress, 0.0, 0.9))
        progress("looking for formulas", 0.9)
        judged = [(data.fitted, data.fitted_mask)]
        content = write_proposal(proposal, out, judged, data.test, report_mask=data.test_mask)
        write_report(out)
        progress("done", 1.0)
    print(content["sentence"])
    tell_curves(content)
    print(f"Written to {arguments.out}; open {arguments.out / 'report.html'}")


def tell_curves(content: dict) -> None:
    """Print each curve with its formula, and how to adopt it."""
    for curve in content["curves"]:
        formula = curve["formula"]
        print(f"  {curve['name']}: {curve['law']}")
        if formula:
            print(f"  {formula['effect']}: {formula['sentence']}  (x in {curve['unit'] or '-'})")
        elif curve["note"]:
            print(f"    {curve['note']}")
