"""``t2l adopt``: add effects of a diagnosis to the model."""

import argparse
from pathlib import Path

from t2l.cli.inputs import add_effects, add_extensions, add_force

HELP = "add effects that a diagnosis found to the model"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Describe the command line."""
    parser.description = (
        "Write a model file with the effects named, at the values fitted by `t2l diagnose`. "
        "Several effects keep the values that each was fitted with alone; `t2l explain` and the "
        "next diagnosis fit them together. A curve or a formula of t2l propose is adopted alike."
    )
    parser.add_argument("names", nargs="+", metavar="EFFECT")
    parser.add_argument(
        "--diagnosis", type=Path, required=True, help="folder of t2l diagnose or propose"
    )
    parser.add_argument("--out", type=Path, required=True, metavar="MODEL.yaml")
    add_effects(parser)
    add_extensions(parser)
    add_force(parser)


def run(arguments: argparse.Namespace) -> None:
    """Merge the models of the diagnosis and write the result.

    Raises:
        ConfigurationError: no diagnosis there, or an effect that it does not hold.
        OutputError: the result would replace something.
    """
    from t2l.diagnose.artefacts import diagnosed_effects
    from t2l.diagnose.files import DIAGNOSIS, PROPOSAL
    from t2l.errors import ConfigurationError
    from t2l.identify.model import merged_with, read_model, write_model
    from t2l.names import path_of
    from t2l.outputs import output_file
    from t2l.propose.artefacts import plain_name, proposed
    from t2l.registry import python_files
    from t2l.typed import describe

    if arguments.out.suffix not in (".yaml", ".yml"):
        raise ConfigurationError(f"--out {arguments.out}: found no .yaml; allowed: MODEL.yaml")
    folder = arguments.diagnosis
    available = [*diagnosed_effects(folder), *proposed(folder)]
    if not available:
        raise ConfigurationError(
            f"--diagnosis {folder}: found no diagnosis and no proposal there; allowed: a folder of "
            "t2l diagnose or t2l propose, or proposal/ of t2l explain"
        )
    merged, models = None, folder / "models"
    for name in arguments.names:
        if name not in available:
            raise ConfigurationError(
                f"{describe(name)}: not in the diagnosis {folder}; it holds {', '.join(available)}"
            )
        path = path_of(models, name, ".yaml")
        model = read_model(path, trusted=python_files(arguments.effects))
        learned = [curve for curve in model.learned if plain_name(curve.law) == name]
        if name not in model.effects and not learned:
            held = ", ".join(model.effects) or "none"
            raise ConfigurationError(
                f"{path}: effects: found {held}; allowed: a model with {name}, as "
                "t2l diagnose wrote it"
            )
        merged = merged_with(merged, model, name)
    # the whole diagnosis, not only what is adopted now
    inputs = [
        folder / DIAGNOSIS,
        folder / PROPOSAL,
        *models.glob("*.yaml"),
        *python_files((*arguments.effects, *arguments.extensions)),
    ]
    with output_file(arguments.out, "t2l adopt", inputs, arguments.force) as out:
        write_model(merged, out, f"adopted from {folder}: {', '.join(arguments.names)}")
    print(f"Written to {arguments.out}")
