"""``t2l check``: has the machine drifted since its model was made?"""

import argparse
from pathlib import Path

from t2l.cli.inputs import add_effects, add_extensions, add_force

HELP = "fit a model's effects to a new log and say which have drifted"

DESCRIPTION = """\
Fit the effects of a model to new recordings, from their adopted values, and judge each. An effect
has drifted if an interval on the new log (95 % for all parameters together) lies outside the
adopted value's own, and if holding it at its adopted values makes the error at least 5 % larger.
The own interval comes from the old logs (--reference); without them it is the value alone.
"""

ENTRIES = ("check.json",)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Describe the command line."""
    parser.description = DESCRIPTION
    parser.add_argument("logs", nargs="+", type=Path, metavar="NEWLOG", help="recording or folder")
    parser.add_argument("--model", type=Path, required=True, metavar="MODEL.yaml")
    parser.add_argument(
        "--reference", nargs="+", type=Path, default=[], metavar="LOG",
        help="recordings that the model was made from",
    )  # fmt: skip
    parser.add_argument("--out", type=Path, help="folder for check.json")
    add_effects(parser)
    add_extensions(parser)
    add_force(parser)


def run(arguments: argparse.Namespace) -> None:
    """Refit, judge, print and write.

    Raises:
        T2LError: a file is wrong, the recordings do not fit the model, or it has no effects.
    """
    from contextlib import nullcontext

    from t2l.cli.inputs import log_output
    from t2l.diagnose.recordings_and_model import (
        check_worth_fitting,
        read_recordings_and_model,
    )
    from t2l.drift.artefacts import CHECK, summary, table, write_check
    from t2l.drift.verdict import verdicts
    from t2l.errors import ConfigurationError
    from t2l.identify.noise_floor import noise_floor
    from t2l.identify.refit import refit
    from t2l.identify.step_size import substeps_for

    model, new, old = read_recordings_and_model(
        arguments.logs, arguments.reference, arguments.model, arguments.effects, "--reference"
    )
    check_worth_fitting(model, new, old)
    if not model.effects:
        raise ConfigurationError(
            f"{arguments.model}: effects: found none; allowed: a model with at least one effect"
        )
    # what --reference names is read too
    arguments.holdout = [arguments.reference]
    claim = log_output(arguments, ENTRIES, model, [*new, *old]) if arguments.out else nullcontext()
    with claim as out:
        substeps = substeps_for(model, new)
        found = refit(model, new, substeps, hold_each=True)
        reference = refit(model, old, substeps) if old else None
        judged = verdicts(found, new[0].joints, reference)
        content = summary(judged, found, noise_floor(new))
        if out is not None:
            write_check(content, out / CHECK)
    print(table(judged))
    print(content["sentence"])
    if arguments.out:
        print(f"Written to {arguments.out}")
