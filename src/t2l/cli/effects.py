"""``t2l effects``: every known effect."""

import argparse
import math
from pathlib import Path

HELP = "list every known effect: what it is, its parameters, units and bounds"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Describe the command line."""
    parser.add_argument("names", nargs="*", metavar="EFFECT", help="only these")
    parser.add_argument(
        "--effects", action="append", type=Path, default=[], metavar="FILE",
        help="Python file, or folder of them, with effects of your own",
    )  # fmt: skip


def run(arguments: argparse.Namespace) -> None:
    """Print the effects.

    Raises:
        ConfigurationError: an unknown name, or a file that defines no effect.
    """
    from t2l.effects.registry import load
    from t2l.errors import ConfigurationError

    known = load(arguments.effects)
    for name in arguments.names:
        if name not in known:
            raise ConfigurationError(f"{name}: unknown effect; known: {', '.join(sorted(known))}")
    for name in arguments.names or sorted(known):
        effect = known[name]
        print(f"{name}\n  {effect.summary[0].upper()}{effect.summary[1:]}.")
        print(f"  Shows in a recording: {effect.signature}.")
        for p in effect.parameters:
            scope = "each joint" if p.per_joint else "the robot"
            print(f"    {p.name} [{p.unit}], {_range(p)}, for {scope}: {p.meaning}")
        print(f"  Source: {effect.source}.\n")


def _range(parameter) -> str:
    """Its bounds in words."""
    lower = f"{parameter.lower:g}" if parameter.lower > -math.inf else "minus the MJCF's own"
    times = f" × ({parameter.scale})" if parameter.scale else ""
    return f"{lower} to {parameter.upper:g}{times}"
