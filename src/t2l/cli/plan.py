"""``t2l plan``: which motions to record, so that effects can be told apart."""

import argparse
from dataclasses import replace
from math import inf
from pathlib import Path

from t2l.cli.inputs import add_effects, add_extensions, add_force
from t2l.cli.words import words
from t2l.errors import MOST_CHARACTERS

HELP = "choose motions that tell effects apart, for t2l record"

DESCRIPTION = """\
Choose motions that will tell physical effects apart. CONFIG.yaml is a configuration of `t2l record`
without an excitation: robot, back end, gains, start. Motions of several kinds are made so small
that the simulated robot keeps a margin to all of its limits. Of these a few are chosen that
together determine the effects best (D-optimal design). OUT receives plan.yaml, which `t2l record`
runs, and the expected error of every parameter. Nothing checks for obstacles.
"""

ENTRIES = ("plan.yaml", "plan.json", "expected_errors.csv", "figures/")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Describe the command line."""
    parser.description = DESCRIPTION
    parser.add_argument("config", type=Path, metavar="CONFIG.yaml")
    parser.add_argument("--model", type=Path, help="the model so far (default: the MJCF as it is)")
    parser.add_argument(
        "--tell", type=words, metavar="EFFECT,EFFECT",
        help="effects to tell apart, see `t2l effects` (default: all that the model lacks)",
    )  # fmt: skip
    add_effects(parser)
    parser.add_argument(
        "--total-s", type=float, default=60.0,
        help="of all motions, 3 to 100 of them (default: 60)",
    )  # fmt: skip
    parser.add_argument("--motion-s", type=float, default=6.0, help="of each motion (default: 6)")
    parser.add_argument(
        "--most-rad", type=float, default=0.5,
        help="largest offset from the start, rad or m (default: 0.5)",
    )  # fmt: skip
    parser.add_argument(
        "--noise-mrad", type=float, default=0.1, help="of a measured position (default: 0.1)"
    )
    parser.add_argument(
        "--workspace", type=_box, metavar="X,Y,Z,X,Y,Z",
        help="box that the tool must stay in: lower and upper corner in m; write --workspace=…",
    )  # fmt: skip
    parser.add_argument("--out", type=Path, required=True, help="folder for the plan")
    add_extensions(parser)
    add_force(parser)


def run(arguments: argparse.Namespace) -> None:
    """Choose, write, and say what will not be told.

    Raises:
        T2LError: the configuration, the model or an effect's name is wrong, or no motion is safe.
    """
    from t2l.cli.inputs import progress_line
    from t2l.design.artefacts import write_experiment
    from t2l.design.experiment import Wanted, check_wanted, design
    from t2l.errors import ConfigurationError, RecordingError
    from t2l.figures.design import expected_errors, experiment_motions
    from t2l.hardware.plan import read_plan, read_setup
    from t2l.outputs import output_folder
    from t2l.plotting.style import write
    from t2l.registry import python_files
    from t2l.robots.plant import files

    setup = read_setup(arguments.config)
    for key in ("excitation", "motions"):
        if getattr(setup.found, key) is not None:
            raise RecordingError(setup.path, f"key {key}", "it", "none: t2l plan chooses motions")
    _check_numbers(arguments)
    if arguments.workspace and not setup.robot.groups[0].tool_site:
        raise ConfigurationError(
            f"--workspace: found a robot without a site for its tool, {setup.robot.name}; allowed: "
            "an MJCF with a site"
        )
    model, effects = _model_and_effects(arguments, setup)
    inputs = [
        arguments.config, *([arguments.model] if arguments.model else []), *files(model.robot),
        *python_files((*model.effect_files, *arguments.extensions)),
    ]  # fmt: skip
    wanted = Wanted(
        effects, arguments.total_s, arguments.motion_s, arguments.most_rad,
        1e-3 * arguments.noise_mrad, arguments.workspace,
    )  # fmt: skip
    check_wanted(setup, wanted)
    with output_folder(arguments.out, "t2l plan", ENTRIES, inputs, arguments.force) as out:
        progress = progress_line()
        experiment = design(setup, model, wanted, progress)
        write_experiment(experiment, setup, out)
        # what is written is what is checked
        plan = read_plan(out / "plan.yaml")
        for name, figure in (
            ("motions", experiment_motions(experiment, setup)),
            ("expected_errors", expected_errors(experiment)),
        ):
            write(figure, [out / "figures" / f"{name}.{end}" for end in ("pdf", "png")])
        progress("done", 1.0)
    duration_s = sum(motion.duration_s for motion in plan.motions)
    print(
        f"{len(plan.motions)} motions of {experiment.considered}, {duration_s:.0f} s in all; "
        f"log-determinant {experiment.log_det:.1f}, {experiment.random:.1f} by chance"
    )
    for sentence in experiment.told.sentences("They"):
        print(f"  {sentence}")
    print(f"Written to {out}; run: t2l record {out / 'plan.yaml'} --out DIR")


def _model_and_effects(arguments: argparse.Namespace, setup):
    from t2l.errors import ConfigurationError
    from t2l.identify.model import Model, check_joints, read_model
    from t2l.registry import python_files
    from t2l.robots.plant import mjcf_path
    from t2l.typed import describe, suggestion

    own = tuple(path.resolve() for path in arguments.effects)
    model = Model(setup.robot.name, {}, own)
    if arguments.model is not None:
        given = read_model(arguments.model, trusted=python_files(own))
        if mjcf_path(given.robot).resolve() != mjcf_path(setup.robot.name).resolve():
            raise ConfigurationError(
                f"{arguments.model}: robot: found {given.robot}; allowed: that of "
                f"{arguments.config}, {setup.robot.name}"
            )
        model = replace(given, effect_files=(*given.effect_files, *own))
        check_joints(arguments.model, model, setup.robot.joints)
    joints = setup.robot.joints
    missing = {
        effect.name: effect
        for effect in model.missing_effects(joints)
        # of a plan no optional column is known beforehand
        if not effect.needs and len(joints) >= effect.least_joints
    }
    for name in arguments.tell or ():
        if name not in missing:
            raise ConfigurationError(
                f"--tell: found {describe(name)}{suggestion(name, list(missing))}; allowed: "
                f"{', '.join(missing)}"
            )
    return model, [missing[name] for name in arguments.tell or missing]


def _check_numbers(arguments: argparse.Namespace) -> None:
    from t2l.errors import ConfigurationError
    from t2l.hardware.excitation_kinds import LONGEST_S

    for key, least, most in (
        ("motion_s", 1.0, LONGEST_S), ("total_s", 1.0, 100 * LONGEST_S), ("most_rad", 1e-3, 10.0),
        ("noise_mrad", 1e-6, 1e3),
    ):  # fmt: skip
        value = getattr(arguments, key)
        if not least <= value <= most:
            option = f"--{key.replace('_', '-')}"
            raise ConfigurationError(f"{option}: found {value:g}; allowed: {least:g} to {most:g}")


def _box(text: str):
    from t2l.hardware.guard import Workspace

    try:
        numbers = tuple(float(word) for word in words(text))
    except ValueError:
        numbers = ()
    low, high = numbers[:3], numbers[3:]
    # a comparison with what is no number is false
    if len(numbers) != 6 or not all(-inf < a < b < inf for a, b in zip(low, high, strict=True)):
        raise argparse.ArgumentTypeError(
            f"found {text[:MOST_CHARACTERS]!r}; allowed: x,y,z,x,y,z, six finite numbers in m, "
            "each of the lower corner below that of the upper"
        )
    return Workspace(low, high)
