"""``t2l compare``: where a model departs from recordings."""

import argparse

from t2l.cli.inputs import add_log_arguments
from t2l.diagnose.files import COMPARISON, TRACES

ENTRIES = (COMPARISON, TRACES, "figures/", "report.html")

HELP = "simulate recordings and show where the model fails"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Describe the command line."""
    parser.description = (
        "Simulate every recording from its measured start with its commands, gains and rates. "
        "OUT receives comparison.json, figures and report.html."
    )
    add_log_arguments(parser, holdout=False)


def run(arguments: argparse.Namespace) -> None:
    """Compare, write, and say where most of the error is."""
    from t2l.cli.estimate import say_how_long
    from t2l.cli.inputs import log_output, long_work, read_inputs
    from t2l.diagnose.compare import compare, write
    from t2l.figures.diagnosis import draw_comparison
    from t2l.report import write_report

    model, recordings, _ = read_inputs(arguments, fitted=False)
    with log_output(arguments, ENTRIES, model, recordings) as out:
        say_how_long(arguments.command, model, recordings)
        motion = sum(recording.duration_s for recording in recordings)
        what = f"simulating {motion:.0f} s of motion"
        comparison = compare(model, recordings, progress=long_work(what))
        write(comparison, out)
        draw_comparison(out)
        write_report(out)
    for contradiction in comparison.contradictions:
        print(f"Contradiction: {contradiction}")
    print(comparison.result)
    for sides in comparison.torque_sides:
        print(sides.sentence)
    print(f"Written to {arguments.out}; open {arguments.out / 'report.html'}")
