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
        "session, logged temperature or supply voltage, another joint's motion, dry friction, "
        "hysteresis or a limit of the motor torque. Blocks of time of LOG fit and choose; "
        "recordings held out report. OUT receives proposal.json, models/ and effects/ for t2l "
        "adopt, and report.html."
    )
    add_log_arguments(parser, holdout=True)


def run(arguments: argparse.Namespace) -> None:
    """Propose, write, and say what was learned."""
    import numpy as np

    from t2l.cli.estimate import say_how_long
    from t2l.cli.inputs import log_output, progress_line, read_inputs
    from t2l.identify.prediction import Predictor
    from t2l.identify.progress import part
    from t2l.identify.step_size import substeps_for
    from t2l.propose.artefacts import write_proposal
    from t2l.propose.proposal import propose
    from t2l.report import write_report

    model, recordings, holdout = read_inputs(arguments)
    with log_output(arguments, ENTRIES, model, [*recordings, *holdout]) as out:
        substeps = substeps_for(model, recordings)
        say_how_long(arguments.command, model, recordings, substeps)
        predictor = Predictor(model.robot, recordings, substeps)
        report = predictor.of(holdout) if holdout else None
        progress = progress_line()
        proposal = propose(model, predictor, report, progress=part(progress, 0.0, 0.9))
        progress("looking for formulas", 0.9)
        every = np.ones(len(predictor.samples), bool)
        content = write_proposal(proposal, out, [(predictor, every)], report)
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
