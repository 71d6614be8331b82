"""``t2l tune``: gains and action scale for a task, searched together."""

import argparse
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from t2l.cli.inputs import add_effects, add_extensions, add_force
from t2l.cli.words import numbers, words

if TYPE_CHECKING:
    from t2l.rl.twin import Machine
    from t2l.robots import Robot

HELP = "search gains and action scale for a task that is learned in simulation"

DESCRIPTION = """\
Search the gains of a robot's position controller together with the action scale of a policy. TASK
is the kind of a task that is learned, such as joint_reach, or a file of one, as in config/tasks.
Each trial trains a policy under gains of its own, within limits of the robot. Success is to be
high; effort and jitter are to be low, and with --logs also the error of transfer to a twin of the
real robot. The answer is the front of trials that none beats in everything. Those are trained again
from other seeds. OUT receives trials.csv, front.csv and a figure. An interrupted search goes on.
"""

JOURNAL_FILE, TRIALS, FRONT, TWIN = "trials.journal", "trials.csv", "front.csv", "twin/"
ENTRIES = (JOURNAL_FILE, TRIALS, FRONT, TWIN, "figures/")

RESUME = "finished trials are kept in trials.journal of --out; the same command goes on"

# options that say the same as keys of a `gain_search`, which has their bounds and defaults: how
# their text becomes a value, and what they are
OPTIONS: Mapping[str, tuple[Any, str]] = {
    "kp": (numbers, "lowest and highest stiffness, N·m/rad, or a factor on a robot's own"),
    "kd": (numbers, "lowest and highest damping, N·m·s/rad, likewise"),
    "action_scale": (numbers, "bounds of the action scales, rad"),
    "trials": (int, "in all; more of them continue a search"),
    "startup": (int, "trials at random, before the others learn from them"),
    "limits": (words, "that constrain: position, velocity, torque, torque_rate"),
    "least_success": (float, "share of episodes that a trial of the front succeeds in"),
    "again": (int, "trainings of each trial of the front from other seeds"),
    "policy_rate_hz": (float, "rate of the policy"),
    "rate_hz": (float, "rate of the physics that trains"),
    "control_rate_hz": (float, "of the robot's loop, where no recordings say it"),
    "horizon_s": (float, "length of an episode"),
    "environments": (int, "robots that are simulated side by side"),
    "updates": (int, "of each policy"),
    "evaluate_every": (int, "updates between evaluations"),
    "workers": (int, "trials at once on a GPU"),
    "seed": (int, "of the search"),
}
REQUIRED = ("kp", "kd")
SHAPES = {numbers: "LOW,HIGH", words: "A,B,…", int: "N", float: "X"}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Describe the command line."""
    parser.description = DESCRIPTION
    parser.add_argument("task", metavar="TASK")
    parser.add_argument("--robot", help="name of the robot (default: that of the task)")
    for name, (kind, what) in OPTIONS.items():
        parser.add_argument(
            _option(name), type=kind, metavar=SHAPES[kind], required=name in REQUIRED, help=what
        )
    parser.add_argument(
        "--logs", nargs="+", type=Path, default=[], metavar="LOG",
        help="recordings of the real robot, or folders, for a twin of it",
    )  # fmt: skip
    parser.add_argument(
        "--model", type=Path,
        help="the twin, a model.yaml of t2l explain; without it --logs are explained first",
    )  # fmt: skip
    add_effects(parser)
    parser.add_argument("--out", type=Path, required=True, help="folder for what is found")
    add_extensions(parser)
    add_force(parser)


def run(arguments: argparse.Namespace) -> None:
    """Search, train the front again, write.

    Raises:
        ConfigurationError: the task, the robot or an option is wrong, gains are unstable at the
            rate of the robot's loop, or recordings are of another robot.
        T2LError: recordings or their model are wrong.
        OutputError: the folder is not this command's.
    """
    from t2l.cli.inputs import say
    from t2l.config.models.learning import ReinforcementLearning
    from t2l.figures.pareto import write_search
    from t2l.outputs import output_folder
    from t2l.registry import python_files
    from t2l.rl import gain_search
    from t2l.rl.gain_table import gain_table, in_words
    from t2l.rl.settings import JOURNAL
    from t2l.rl.trials import open_study
    from t2l.rl.twin import check_task

    entry, (name, parameters) = _entry(arguments), _task(arguments)
    learning = ReinforcementLearning().model_dump()
    inputs = [
        *arguments.logs, *([arguments.model] if arguments.model else []),
        *([Path(arguments.task)] if _is_file(arguments.task) else []),
        *python_files((*arguments.extensions, *arguments.effects)),
    ]  # fmt: skip
    # what is wrong without recordings is found before a twin is made of them
    of_task = (entry, name, parameters, learning)
    problem, search, settings = gain_search.of_entry(*of_task)
    gain_search.check(problem, search, settings)
    if arguments.logs:
        check_task(problem.task)
    with output_folder(arguments.out, "t2l tune", ENTRIES, inputs, arguments.force) as out:
        if machine := _twin(arguments, problem.task.robot, out / TWIN):
            problem, *_ = gain_search.of_entry(*of_task, machine)
            gain_search.check(problem, search, settings)
        study = open_study(
            JOURNAL, out / JOURNAL_FILE, problem.study_name(search, settings, entry["seed"]),
            list(problem.objectives.values()),
        )  # fmt: skip
        running = (study, problem, search, settings)
        gain_search.work(*running, entry["seed"], entry["workers"], 1, say)
        gain_search.confirm(*running, 1, say)
        trials = gain_table(study, problem.objectives)
        write_search(trials, out)
    print(in_words(trials, problem.objectives))
    print(f"Written to {arguments.out}")


def _option(name: str) -> str:
    return f"--{name.replace('_', '-')}"


def _entry(arguments: argparse.Namespace) -> dict[str, Any]:
    """What the options say, checked, with the defaults of the configuration."""
    from t2l.config.models.gain_search import GainSearchEntry
    from t2l.errors import ConfigurationError
    from t2l.typed import Invalid, check

    given = {name: getattr(arguments, name) for name in OPTIONS}
    try:
        found = check(GainSearchEntry, {k: v for k, v in given.items() if v is not None})
    except Invalid as error:
        lines = [str(replace(p, key=_option(p.key))) for p in error.problems]
        raise ConfigurationError("\n".join(lines)) from None
    return found.model_dump()


def _is_file(task: str) -> bool:
    return task.endswith((".yaml", ".yml"))


def _task(arguments: argparse.Namespace) -> tuple[str, dict[str, Any]]:
    """The name and the parameters of the task."""
    from t2l.config.tasks import checked_task, read_task_file
    from t2l.errors import ConfigurationError
    from t2l.tasks import TASKS, Rewarded
    from t2l.typed import Invalid, describe, suggestion

    robot = {} if arguments.robot is None else {"robot": arguments.robot}
    if _is_file(arguments.task):
        path = Path(arguments.task)
        name, parameters = path.stem, read_task_file(path, **robot)
    else:
        name, learned = arguments.task, _learned()
        if name not in learned:
            raise ConfigurationError(
                f"TASK: found {describe(name)}{suggestion(name, learned)}; allowed: "
                f"{', '.join(learned)}, or a file of a task, NAME.yaml"
            )
        try:
            parameters = checked_task({"kind": name, **robot})
        except Invalid as error:
            raise ConfigurationError(f"{name}: {error}") from None
    if not issubclass(TASKS.find(parameters["kind"]), Rewarded):
        raise ConfigurationError(
            f"{arguments.task}: found a task without a reward; allowed: {', '.join(_learned())}"
        )
    return name, parameters


def _learned() -> list[str]:
    from t2l.tasks import TASKS, Rewarded

    return [name for name in TASKS.names() if issubclass(TASKS.find(name), Rewarded)]


def _twin(arguments: argparse.Namespace, robot: "Robot", folder: Path) -> "Machine | None":
    """The machine of the recordings; found in them first if no model is given."""
    from t2l.cli.inputs import progress_line, say
    from t2l.detective.data_split import split
    from t2l.detective.explanation import explained
    from t2l.diagnose.files import MODEL
    from t2l.diagnose.recordings_and_model import check_worth_fitting, read_recordings_and_model
    from t2l.errors import ConfigurationError
    from t2l.identify.model import read_again
    from t2l.identify.step_size import substeps_for
    from t2l.rl.twin import Machine

    if not arguments.logs:
        if arguments.model:
            raise ConfigurationError(
                "--model: found no --logs beside it, which say the rate of the loop; allowed: both"
            )
        return None
    model, recordings, _ = read_recordings_and_model(
        arguments.logs, (), arguments.model, arguments.effects
    )
    machine = Machine.of(model, recordings, robot)
    if arguments.model is not None:
        return machine
    check_worth_fitting(model, recordings)
    say("the recordings are explained first, as t2l explain does")
    data = split(model.robot, recordings, (), substeps_for(model, recordings))
    explained(model, data, say, progress_line(), folder=folder)
    return replace(machine, model=read_again(folder / MODEL, model))
