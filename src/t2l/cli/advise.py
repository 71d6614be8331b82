"""``t2l advise``: gains for a robot, before anything is trained."""

import argparse
import hashlib
import json
import logging
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from t2l.cli.inputs import add_effects, add_extensions, add_force
from t2l.cli.words import numbers, words

if TYPE_CHECKING:
    from t2l.advise.advice import Advice, Asked
    from t2l.cli.advice_inputs import Body
    from t2l.demos.demonstration import Demonstration
    from t2l.identify.model import Model
    from t2l.recordings.recording import Recording
    from t2l.tasks import Demonstrated

HELP = "say which gains suit a robot for behaviour cloning, which do not, and why"

DESCRIPTION = """\
Look at a grid of stiffness and damping for a robot's position controller. Of each joint the loop is
computed as it is sampled, with what a model or recordings say of the real machine. Gains that ring,
are near unstable, sag, or cannot follow demonstrations are ruled out, with the reason. The others
are put in the order in which cloning is predicted to succeed. ROBOT is a name, or the path of an
MJCF or URDF file. OUT receives report.html, gains.yaml, advice.json and figures.
"""

FIRST = Path("figures/first.png")
ENTRIES = (
    "report.html", "advice.json", "gains.yaml", "model.yaml", "trainings.yaml", "figures/",
)  # fmt: skip
RESUME = "finished trainings are kept in trainings.yaml of --out; the same command goes on"
ROLLOUTS = 100  # convention: of each policy that is trained, as in the studies
# measured: on one core of 2 GHz, that a demonstration of a table-top task takes, a joint
DEMONSTRATION_S = 0.07
OTHERWISE_S = 12.0  # measured: imports, labels, figures
ENDING = 0.8  # guess: of --time, after which explaining begins nothing new
PAGE_DPI = 110  # format: a page holds them whole
TIMED_STEPS = 200  # numerics: of the plant, by which the replay is timed


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Describe the command line."""
    parser.description = DESCRIPTION
    parser.add_argument("robot", metavar="ROBOT")
    parser.add_argument(
        "--joints", type=words, metavar="A,B,...", help="that the controller moves (default: all)"
    )
    known = parser.add_argument_group("what is known of the real machine")
    known.add_argument(
        "--logs", nargs="+", type=Path, default=[], metavar="LOG",
        help="recordings of it, or folders, which are explained first as t2l explain does",
    )  # fmt: skip
    known.add_argument("--model", type=Path, help="a model.yaml of t2l explain, in place of that")
    known.add_argument(
        "--time", type=float, default=30.0, metavar="SECONDS",
        help="after which explaining --logs is ended (default: 30)",
    )  # fmt: skip
    known.add_argument(
        "--control-rate", type=float, metavar="HZ",
        help="of the robot's loop (default: of --logs, or 1000)",
    )  # fmt: skip
    known.add_argument(
        "--no-gravity-compensation", action="store_true",
        help="the controller does not carry the weight (default: as --logs say, or it does)",
    )  # fmt: skip
    add_effects(parser)
    shown = parser.add_argument_group("what it is to do")
    shown.add_argument(
        "--demonstrations", type=Path, metavar="DATASET", help="a LeRobot data set on disk"
    )
    shown.add_argument("--task", help="file of a task that an expert shows, as in config/tasks")
    shown.add_argument(
        "--count", type=int, default=50, help="demonstrations of the expert (default: 50)"
    )
    shown.add_argument(
        "--recorded-kp", type=numbers, metavar="KP",
        help="stiffness that the data set was recorded under, N·m/rad, one or one for each joint",
    )  # fmt: skip
    shown.add_argument(
        "--recorded-kd", type=numbers, metavar="KD", help="damping likewise, N·m·s/rad"
    )
    shown.add_argument("--degrees", action="store_true", help="the data set is in degrees")
    shown.add_argument(
        "--policy-rate", type=float, default=50.0, metavar="HZ", help="(default: 50)"
    )
    parser.add_argument(
        "--for", dest="ways", type=words, metavar="A,B", default=["cloning", "reinforcement"],
        help="what learns: cloning, reinforcement (default: both)",
    )  # fmt: skip
    parser.add_argument(
        "--train", type=int, default=0, metavar="N",
        help="clone N policies of --task where that settles most, and update the answer",
    )  # fmt: skip
    parser.add_argument(
        "--kp", type=numbers, metavar="A,B,...", help="stiffnesses to look at (default: by inertia)"
    )
    parser.add_argument("--kd", type=numbers, metavar="A,B,...", help="dampings, likewise")
    parser.add_argument(
        "--most-sag", type=float, default=0.1, metavar="RAD",
        help="by which a joint may hang low at rest (default: 0.1)",
    )  # fmt: skip
    parser.add_argument(
        "--out", type=Path, default=Path("advice"), help="folder for the answer (default: advice)"
    )
    add_extensions(parser)
    add_force(parser)


def run(arguments: argparse.Namespace) -> None:
    """Advise, write, and say the answer.

    Raises:
        ConfigurationError: an option, the robot or the task is wrong, or no gains hold a joint.
        RecordingError: recordings or demonstrations are wrong, or of another robot.
        OutputError: the folder is not this command's.
    """
    from t2l.advise.advice import advised
    from t2l.advise.files import write_advice
    from t2l.advise.words import headline, most_common
    from t2l.cli.advice_inputs import asked_of, body_of, by_expert, machine_of, shown_of
    from t2l.cli.inputs import progress_line, say
    from t2l.identify.model import write_model
    from t2l.identify.progress import part
    from t2l.outputs import output_folder
    from t2l.registry import python_files
    from t2l.robots.plant import files

    began = time.monotonic()
    _check(arguments)
    body = body_of(arguments)
    model, recordings = machine_of(arguments, body)
    inputs = [
        *arguments.logs, *(path for path in (arguments.model, arguments.demonstrations) if path),
        *([Path(arguments.task)] if arguments.task else []), *files(model.robot),
        *python_files((*model.effect_files, *arguments.extensions)),
    ]  # fmt: skip
    with output_folder(arguments.out, "t2l advise", ENTRIES, inputs, arguments.force) as out:
        say(f"This takes about {_about_s(arguments, body, recordings):.0f} s on this machine.")
        progress = progress_line()
        measured = known = arguments.model is not None
        progress("demonstrations", 0.0)
        # what is known of an arm is true of it with a hand
        machine = replace(model, robot=body.robot)
        with _first_picture(asked_of(arguments, body, machine, recordings, None), out):
            demonstrated = by_expert(arguments, body)
            shown = shown_of(arguments, body, recordings, demonstrated)
            if recordings and arguments.model is None:
                progress("explaining the recordings", 0.1)
                model, measured, known = _explained(arguments, model)
            machine = replace(model, robot=body.robot)
            asked = replace(
                asked_of(arguments, body, machine, recordings, shown),
                known=known,
                ways=tuple(arguments.ways),
            )
            advice = advised(asked, part(progress, 0.5, 0.9))
            if arguments.train and demonstrated is not None:
                advice = _trained(arguments, advice, *demonstrated, out)
        progress("figures", 0.9)
        write_advice(advice, out)
        if measured:
            write_model(model, out / "model.yaml")
        _draw(advice, out, measured)
        progress("done", 1.0)
    print(headline(advice))
    for sentence in most_common(advice):
        print(f"  ruled out: {sentence}")
    print(
        f"Written to {arguments.out} in {time.monotonic() - began:.0f} s; open "
        f"{arguments.out / 'report.html'}"
    )


def _check(arguments: argparse.Namespace) -> None:
    from t2l.cli.advice_inputs import listed
    from t2l.errors import ConfigurationError

    for key, least, most in (
        ("policy_rate", 1.0, 1000.0), ("control_rate", 10.0, 20_000.0), ("count", 2, 1000),
        ("time", 1.0, 604_800.0), ("most_sag", 1e-6, 3.0), ("train", 0, 1000),
    ):  # fmt: skip
        value = getattr(arguments, key)
        if value is not None and not least <= value <= most:
            option = f"--{key.replace('_', '-')}"
            raise ConfigurationError(f"{option}: found {value:g}; allowed: {least:g} to {most:g}")
    if arguments.demonstrations and arguments.task:
        raise ConfigurationError("--demonstrations and --task: found both; allowed: one of them")
    _check_ways(arguments)
    _check_trainings(arguments)
    given = arguments.recorded_kp is not None, arguments.recorded_kd is not None
    if given[0] != given[1] or (given[0] and not arguments.demonstrations):
        raise ConfigurationError(
            "--recorded-kp and --recorded-kd: found one of them, or no --demonstrations; allowed: "
            "both, beside a data set"
        )
    if (arguments.kp is None) != (arguments.kd is None):
        raise ConfigurationError("--kp and --kd: found one of them; allowed: both or none")
    for key in ("kp", "kd"):
        values = listed(getattr(arguments, key))
        if values is not None and (not all(0 < v < 1e9 for v in values) or len(values) > 30):
            raise ConfigurationError(
                f"--{key}: found {values}; allowed: up to 30 numbers above 0, as 32,64,128"
            )


def _check_ways(arguments: argparse.Namespace) -> None:
    from t2l.advise.advice import CLONING, WAYS
    from t2l.errors import ConfigurationError

    for way in arguments.ways:
        if way not in WAYS:
            why = " (nothing is known that ranks gains for it)" if way == "transfer" else ""
            raise ConfigurationError(f"--for: found {way}{why}; allowed: {', '.join(WAYS)}")
    if arguments.train and CLONING not in arguments.ways:
        raise ConfigurationError("--train: found no cloning in --for; allowed: with it")


def _check_trainings(arguments: argparse.Namespace) -> None:
    from t2l.errors import ConfigurationError
    from t2l.sim.batch import TIMESTEP_S

    if not arguments.train:
        return
    if not arguments.task:
        raise ConfigurationError(
            "--train: found no --task; allowed: with one, whose expert shows it and whose "
            "simulator tries policies"
        )
    steps = 1 / (TIMESTEP_S * arguments.policy_rate)
    if steps < 1 or abs(steps - round(steps)) > 1e-9:
        raise ConfigurationError(
            f"--policy-rate: found {arguments.policy_rate:g} Hz; allowed with --train: a divisor "
            f"of the simulation's {1 / TIMESTEP_S:g} Hz"
        )


def _trained(
    arguments: argparse.Namespace,
    advice: "Advice",
    task: "Demonstrated",
    demonstrations: "list[Demonstration]",
    out: Path,
) -> "Advice":
    """The answer after --train policies, by the defaults of a study's configuration."""
    from t2l.advise.advice import settled
    from t2l.advise.trained import FILE, Recipe, trainings_of
    from t2l.cli.advice_inputs import cores
    from t2l.cli.inputs import say
    from t2l.config.models.actions import ClonedActions
    from t2l.config.models.cloning import Rollouts, Training

    training = Training().model_dump()
    recipe = Recipe(
        task, demonstrations, training, ClonedActions().model_dump(exclude_none=True),
        arguments.policy_rate, ROLLOUTS, Rollouts().executed_actions, cores(),
    )  # fmt: skip
    grid = advice.asked.grid
    of = {
        "task": Path(arguments.task).read_text(), "robot": arguments.robot, "kp": grid.kp,
        "kd": grid.kd, "count": arguments.count, "policy_rate": arguments.policy_rate,
        "training": training,
    }  # fmt: skip
    digest = hashlib.sha256(json.dumps(of, sort_keys=True).encode()).hexdigest()[:12]
    key = f"{Path(arguments.task).stem} by {arguments.robot}, {digest}"
    with _epochs_told():
        found = trainings_of(advice, recipe, arguments.train, out / FILE, key, say)
    return settled(advice, found)


@contextmanager
def _epochs_told() -> Iterator[None]:
    """Every epoch as a line of progress."""
    from t2l.cli.inputs import progress_line

    line, log = progress_line(), logging.getLogger("t2l.policies.training")
    handler, level = logging.Handler(), log.level
    handler.emit = lambda record: line(record.getMessage(), 0.0)
    log.addHandler(handler)
    log.setLevel(logging.INFO)
    try:
        yield
    finally:
        log.removeHandler(handler)
        log.setLevel(level)


def _explained(arguments: argparse.Namespace, model: "Model") -> "tuple[Model, bool, bool]":
    """What the recordings show within --time, after which the search is ended wherever it is.

    Also whether a round of it ended in that time, and whether no more than noise was left then.

    Raises:
        ConfigurationError: it failed, and said why.
    """
    from t2l.cli.inputs import say
    from t2l.diagnose.files import MODEL
    from t2l.diagnose.ranking import NOTHING_MISSING, verdict_of
    from t2l.diagnose.results import read_found
    from t2l.errors import ConfigurationError
    from t2l.identify.model import read_again

    say(f"the recordings are explained first, for up to {arguments.time:g} s")
    with tempfile.TemporaryDirectory() as folder:
        files = (
            (option, path)
            for option in ("effects", "extensions")
            for path in getattr(arguments, option)
        )
        command = [
            sys.executable, "-m", "t2l", "explain", *arguments.logs, "--out", folder,
            "--time", f"{ENDING * arguments.time:g}",
            *(text for option, path in files for text in (f"--{option}", path)),
        ]  # fmt: skip
        # a process of its own: a fit at hand cannot be ended otherwise
        with suppress(subprocess.TimeoutExpired):
            ended = subprocess.run(
                [*map(str, command)], timeout=arguments.time, stdout=subprocess.DEVNULL
            )
            if ended.returncode:
                raise ConfigurationError("--logs: found recordings that t2l explain cannot explain")
        found = Path(folder, MODEL)
        if not found.exists():
            say("nothing was explained in that time; give it more by --time")
            return model, False, False
        told = read_found(folder).explanation
        left, noise = told["steps"][-1]["validation_rmse_q_rad"], told["noise_floor_rad"]
        quiet = verdict_of(left, noise, justified=False) == NOTHING_MISSING
        if not quiet:
            say(
                f"{1e3 * left:.3g} mrad are left, the noise is {1e3 * noise:.3g}: the machine "
                "counts as not yet known, and gains keep a margin of two"
            )
        return read_again(found, model), True, quiet


def _about_s(arguments: argparse.Namespace, body: "Body", recordings: "list[Recording]") -> float:
    """Seconds that all of it takes, by some steps of the robot."""
    import mujoco

    from t2l.advise.grid import DAMPINGS, FREQUENCIES_HZ
    from t2l.advise.retargeted import LONGEST_S, REPLAYED
    from t2l.cli.advice_inputs import control_rate_hz, cores, listed
    from t2l.identify.prediction import with_effects

    total = OTHERWISE_S
    if recordings and arguments.model is None:
        total += arguments.time
    if arguments.task:
        total += DEMONSTRATION_S * len(body.joints) * arguments.count / min(cores(), 2)
    if arguments.task or arguments.demonstrations:
        model = with_effects(body.robot, body.joints)
        data = mujoco.MjData(model)
        began = time.perf_counter()
        mujoco.mj_step(model, data, TIMED_STEPS)
        each = (time.perf_counter() - began) / TIMED_STEPS
        kp, kd = listed(arguments.kp), listed(arguments.kd)
        cells = len(kp) * len(kd) if kp and kd else len(FREQUENCIES_HZ) * len(DAMPINGS)
        rate = control_rate_hz(arguments, recordings)
        total += cells * REPLAYED * LONGEST_S * max(rate, 1000.0) * each / cores()
    return total


@contextmanager
def _first_picture(asked: "Asked", out: Path) -> Iterator[None]:
    """The loop over the grid as it is known so far, for who waits; gone again if the body fails."""
    from t2l.advise.advice import advised
    from t2l.cli.inputs import say
    from t2l.errors import ConfigurationError
    from t2l.figures.advice import advice_maps
    from t2l.plotting.style import write

    path = out / FIRST
    # what rules out every pair alone may not, beside demonstrations
    with suppress(ConfigurationError):
        write(advice_maps(advised(asked)), [path], PAGE_DPI)
        say(f"A first picture, of the loop as it is known so far: {path}")
    try:
        yield
    except BaseException:
        path.unlink(missing_ok=True)
        with suppress(OSError):
            path.parent.rmdir()
        raise


def _draw(advice: "Advice", out: Path, measured: bool) -> None:
    from t2l.figures.advice import advice_maps, reasons
    from t2l.plotting.style import write
    from t2l.report.advice import write_advice_page

    pictures = {}
    for name, figure in (("maps", advice_maps(advice)), ("reasons", reasons(advice))):
        pictures[name] = out / "figures" / f"{name}.png"
        write(figure, [out / "figures" / f"{name}.pdf", pictures[name]], PAGE_DPI)
    write_advice_page(advice, pictures, out, measured)
