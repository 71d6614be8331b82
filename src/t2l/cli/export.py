"""``t2l export``: an adopted model for other people's simulators."""

import argparse
from pathlib import Path

from t2l.cli.inputs import add_effects, add_extensions, add_force
from t2l.cli.words import numbers, words

HELP = "write a model as plain MJCF, with a Python callback for what MJCF lacks"

DESCRIPTION = """\
Write a model as plain MJCF that MuJoCo steps alone, and robot.py beside it, which runs it and adds
what MJCF has no element for. export.json says what is where, what could not be carried, and how far
the exported robot is from t2l's prediction. With recordings (--logs), gains and rate are theirs,
and a refit of the model gives ranges for domain randomisation.
"""

ENTRIES = ("model.xml", "robot.py", "robot.json", "export.json")
WITHOUT_LOGS = ("kp", "kd", "control_rate_hz", "gravity_compensation")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Describe the command line."""
    parser.description = DESCRIPTION
    parser.add_argument("model", type=Path, metavar="MODEL.yaml")
    parser.add_argument(
        "--logs", nargs="+", type=Path, default=[], metavar="LOG",
        help="recordings or folders; the first gives the gains of the MJCF",
    )  # fmt: skip
    without = parser.add_argument_group("without --logs")
    without.add_argument(
        "--joints", type=words, metavar="A,B,...", help="all hinges and slides unless given"
    )
    without.add_argument("--kp", type=numbers, help="N·m/rad, one number or one for each joint")
    without.add_argument("--kd", type=numbers, help="N·m·s/rad, likewise")
    without.add_argument("--control-rate-hz", type=float)
    without.add_argument("--gravity-compensation", choices=("yes", "no"))
    parser.add_argument("--out", type=Path, required=True, help="folder for the exported model")
    add_effects(parser)
    add_extensions(parser)
    add_force(parser)


def run(arguments: argparse.Namespace) -> None:
    """Export, compare with t2l's prediction, and say what was carried.

    Raises:
        T2LError: the model or a recording is wrong, or gains are given twice or not at all.
    """
    from t2l.diagnose.recordings_and_model import read_recordings_and_model
    from t2l.errors import RecordingError
    from t2l.export.agreement import difference
    from t2l.export.folder import write_export, write_summary
    from t2l.export.mjcf import Controller
    from t2l.identify.loop_stability import check_settles
    from t2l.identify.model import read_model
    from t2l.identify.refit import refit
    from t2l.outputs import output_folder
    from t2l.recordings.control import POSITION
    from t2l.registry import python_files
    from t2l.robots.plant import files

    recordings, found, alike = [], None, []
    _check_options(arguments)
    if arguments.logs:
        model, recordings, _ = read_recordings_and_model(
            arguments.logs, (), arguments.model, arguments.effects
        )
        for recording in recordings:
            if recording.drifts:
                raise RecordingError(
                    recording.path, "key control", recording.control,
                    f"{POSITION}: the exported robot takes positions",
                )  # fmt: skip
            if recording.motor is not None:
                allowed = "drives that give the torque they are asked for"
                raise RecordingError(recording.path, "key motor", "it", allowed)
        check_settles(model, recordings)
        first = recordings[0]
        controller = Controller(
            first.joints,
            first.kp,
            first.kd,
            first.control_rate_hz,
            bool(first.gravity_compensation),
        )
    else:
        model = read_model(arguments.model, trusted=python_files(arguments.effects))
        controller = _controller(arguments, model)
    tables = [recording.path for recording in recordings]
    inputs = [
        *arguments.logs, arguments.model, *tables, *(path.with_suffix(".yaml") for path in tables),
        *python_files((*model.effect_files, *arguments.extensions)), *files(model.robot),
    ]  # fmt: skip
    with output_folder(arguments.out, "t2l export", ENTRIES, inputs, arguments.force) as out:
        layout, u = model.vector(controller.joints)
        if recordings and len(u):
            found = refit(model, recordings).found
        content = write_export(model, controller, layout, u, found, out)
        alike = [r for r in recordings if _same_loop(r, controller) and _by_position(r)][:5]
        if alike:
            content["from_t2l_rad"] = difference(out, model, layout, u, alike)
            write_summary(content, out)
    for key, text in (("in_mjcf", "In the MJCF"), ("by_callback", "By callback")):
        print(f"{text}: {', '.join(content[key]) or 'nothing'}")
    if content["of_the_log"]:
        print(f"Of the log, not of the robot: {', '.join(content['of_the_log'])}")
    for effect, why in content["not_carried"].items():
        print(f"Not carried: {effect}: {why}")
    if not all(map(_by_position, recordings)):
        print(
            "The exported robot takes positions alone: recordings with dq_des or tau_ff are not "
            "compared with it"
        )
    if alike:
        print(f"The exported robot is {1e3 * content['from_t2l_rad']:.3g} mrad from t2l's")
    print(f"Written to {arguments.out}")


def _same_loop(recording, controller) -> bool:
    return bool(
        (recording.kp == controller.kp).all()
        and (recording.kd == controller.kd).all()
        and recording.control_rate_hz == controller.control_rate_hz
    )


def _by_position(recording) -> bool:
    return recording.dq_des is None and recording.tau_ff is None


def _check_options(arguments: argparse.Namespace) -> None:
    from t2l.errors import ConfigurationError

    given = [name for name in WITHOUT_LOGS if getattr(arguments, name) is not None]
    option = "--{}".format
    if arguments.logs and (given or arguments.joints):
        name = (given or ["joints"])[0].replace("_", "-")
        raise ConfigurationError(f"{option(name)}: found it with --logs; allowed: one of the two")
    missing = [name for name in WITHOUT_LOGS if name not in given]
    if not arguments.logs and missing:
        name = missing[0].replace("_", "-")
        raise ConfigurationError(
            f"{option(name)}: found nothing; allowed: --logs LOG, or all of "
            + ", ".join(option(each.replace("_", "-")) for each in WITHOUT_LOGS)
        )


def _controller(arguments: argparse.Namespace, model):
    from t2l.cli.inputs import gain_of_each
    from t2l.errors import ConfigurationError
    from t2l.export.mjcf import Controller
    from t2l.identify.model import check_joints
    from t2l.robots import plant
    from t2l.robots.registry import ROBOTS, make_robot
    from t2l.typed import suggestion

    known = tuple(joint.name for joint in plant.scalar_joints(model.robot))
    whose = "the robot has"
    if arguments.joints:
        joints, whose = tuple(arguments.joints), "--joints names"
        for joint in joints:
            if joint not in known or joints.count(joint) > 1:
                raise ConfigurationError(
                    f"--joints: found {joint!r}{suggestion(joint, known)}; allowed: different "
                    f"ones of {', '.join(known)}"
                )
    elif model.robot in ROBOTS.names():
        joints = make_robot(model.robot).joints
    else:
        joints = known
    check_joints(arguments.model, model, joints, whose)
    gains = {name: gain_of_each(arguments, name, joints) for name in ("kp", "kd")}
    rate = arguments.control_rate_hz
    if not 1 <= rate <= 100_000:
        raise ConfigurationError(f"--control-rate-hz: found {rate:g}; allowed: 1 to 100000")
    return Controller(joints, **gains, control_rate_hz=rate,
                      gravity_compensation=arguments.gravity_compensation == "yes")  # fmt: skip
