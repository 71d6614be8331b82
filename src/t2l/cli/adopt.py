"""``t2l adopt``: add effects of a diagnosis to the model."""

import argparse
from pathlib import Path

HELP = "add effects that a diagnosis found to the model"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Describe the command line."""
    parser.description = (
        "Write a model file with the effects named, at the values fitted by `t2l diagnose`. "
        "Several effects keep the values that each was fitted with alone; `t2l explain` and the "
        "next diagnosis fit them together."
    )
    parser.add_argument("effects", nargs="+", metavar="EFFECT")
    parser.add_argument("--diagnosis", type=Path, required=True, help="folder of t2l diagnose")
    parser.add_argument("--out", type=Path, required=True, metavar="MODEL.yaml")


def run(arguments: argparse.Namespace) -> None:
    """Merge the models of the diagnosis and write the result.

    Raises:
        ConfigurationError: no diagnosis there, or an effect that it does not hold.
    """
    from t2l.discrepancy.model import Model, read_model, write_model
    from t2l.errors import ConfigurationError

    folder = arguments.diagnosis / "models"
    available = sorted(path.stem for path in folder.glob("*.yaml"))
    if not available:
        raise ConfigurationError(f"--diagnosis {arguments.diagnosis}: no diagnosis in that folder")
    merged = None
    for name in arguments.effects:
        if name not in available:
            raise ConfigurationError(
                f"{name}: not in the diagnosis {arguments.diagnosis}; it holds "
                f"{', '.join(available)}"
            )
        model = read_model(folder / f"{name}.yaml")
        effects = {**(merged.effects if merged else model.effects), name: model.effects[name]}
        merged = Model(model.robot, effects, model.effect_files)
    write_model(
        merged, arguments.out, f"adopted from {arguments.diagnosis}: {', '.join(arguments.effects)}"
    )
    print(f"Written to {arguments.out}")
