"""Reading and checking a whole configuration before any job exists."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pydantic import create_model

from t2l.config import files, relations, robot, sizes, storage, variants
from t2l.config.cells import fidelity_cells, grid_of, transfer_cells
from t2l.config.models import Configuration
from t2l.config.relations import SIMULATION_RATE_HZ
from t2l.config.tasks import read_task
from t2l.config.training import configuration_model
from t2l.errors import ConfigurationError
from t2l.gains import Cell, Grid
from t2l.hardware import Features
from t2l.registry import load_extensions
from t2l.rl.problem import Condition
from t2l.tasks import make_task
from t2l.typed import Invalid, Typed, check

# more of them are seldom read
MOST_LINES = 50


@dataclass(frozen=True)
class Study:
    """A checked configuration.

    Attributes:
        sections: the whole configuration, by section, as `effective` has it.
        tasks: the content of config/tasks/NAME.yaml for every task of the study, of either chain.
        grid: the gains that behaviour cloning runs over.
        fidelity_cells: the gains that retargeting is validated at.
        recording_grid: the gains that sim-to-real transfer runs over.
        transfer_cells: those of them that are run.
        robot: what the robot at the other end can do.
        conditions: what policies are trained and deployed under; none where the robot is only
            recorded.
        variants: for each variant of behaviour cloning, the nominal first: its sections
            `variants.SECTIONS`, None for one that it lacks, and `decimation`, timesteps of the
            simulation per policy step.
    """

    sections: Mapping[str, Any]
    tasks: Mapping[str, Mapping[str, Any]]
    grid: Grid
    fidelity_cells: tuple[Cell, ...]
    recording_grid: Grid
    transfer_cells: tuple[Cell, ...]
    robot: Features
    conditions: tuple[Condition, ...]
    variants: Mapping[str, Mapping[str, Any]]


def effective(config: Mapping[str, Any]) -> dict[str, Any]:
    """A configuration with every default filled in.

    Returns:
        Plain dicts, lists and numbers by section; whole numbers of keys that take no others are
        int. Optional keys and sections without a default are absent if they are not given.

    Raises:
        Invalid: with every key that is wrong by itself.
    """
    return _sections(check(configuration_model(config), config))


def _extensions(config: Any) -> list[str] | None:
    """The key of this name, if it is as it should be; what it is else is told with all others."""
    field = Configuration.model_fields["extensions"]
    model = create_model(
        "Extensions", __base__=Typed, extensions=(field.rebuild_annotation(), field)
    )
    try:
        return check(
            model, {key: config[key] for key in ("extensions",) if key in config}
        ).extensions
    except (Invalid, TypeError):
        return None


def _extend(extensions: Sequence[str] | None) -> None:
    """Load what names may come from, before any is looked up."""
    problems = files.extended(extensions)
    if problems:
        raise _error(f"config: {problem}" for problem in problems)
    try:
        load_extensions(extensions or [])
    except ConfigurationError as error:
        raise _error([f"config: extensions: {error}"]) from None


def _sections(configuration: Configuration) -> dict[str, Any]:
    return configuration.model_dump(exclude_none=True)


def read_study(config: Mapping[str, Any], folder: Path) -> Study:
    """Check `config`, the tasks in `folder`/tasks that it names, and that its files are there.

    Its extensions are loaded, for the rest of the process.

    Raises:
        ConfigurationError: with a line for every offending key: what was found, what is allowed.
    """
    # the section `training` is that of a policy, which may be the user's own
    _extend(_extensions(config))
    try:
        configuration = check(configuration_model(config), config)
    except Invalid as error:
        raise _error(f"config: {problem}" for problem in error.problems) from None
    conditions = configuration.sim_to_real.conditions
    named = {f"tasks[{i}]": name for i, name in enumerate(configuration.tasks)}
    if configuration.decoupling:
        named["decoupling.task"] = configuration.decoupling.task
    named |= {f"sim_to_real.conditions[{i}].task": c.task for i, c in enumerate(conditions)}
    if configuration.learning:
        learned = enumerate(configuration.learning.tasks)
        named |= {f"learning.tasks[{i}].task": entry.task for i, entry in learned}
        searched = enumerate(configuration.learning.gain_searches)
        named |= {f"learning.gain_searches[{i}].task": entry.task for i, entry in searched}
    tasks, lines = _read_tasks(named, folder / "tasks")
    made = {name: make_task(task) for name, task in tasks.items()}
    cells = transfer_cells(configuration)
    nominal = [*relations.problems(configuration, made), *sizes.problems(configuration, made)]
    by_variant, problems = variants.configurations(config, configuration)
    for name, variant in by_variant.items():
        own = [*relations.problems(variant, made), *sizes.problems(variant, made)]
        problems += variants.differing(name, own, nominal)
    problems += [
        *nominal,
        *storage.problems(configuration.tuning.storage),
        *robot.problems(configuration.robot, cells),
        *files.published(configuration.attenuation),
        *files.twins(configuration.learning),
        *(files.diagnosed(configuration.diagnosis) if configuration.diagnosis else []),
    ]
    if lines or problems:
        raise _error([*lines, *(f"config: {problem}" for problem in problems)])
    sections = _sections(configuration)
    conditions = tuple(
        Condition(**entry, parameters=tasks[entry["task"]])
        for entry in sections["sim_to_real"]["conditions"]
    )
    return Study(
        sections=sections,
        tasks=tasks,
        grid=grid_of(configuration.grid),
        fidelity_cells=fidelity_cells(configuration.fidelity),
        recording_grid=grid_of(configuration.recording_grid),
        transfer_cells=cells,
        robot=(features := robot.features(configuration.robot)),
        conditions=conditions if features.takes_commands else (),
        variants={name: _cloning(variant) for name, variant in by_variant.items()},
    )


def _cloning(configuration: Configuration) -> dict[str, Any]:
    sections = _sections(configuration)
    decimation = round(SIMULATION_RATE_HZ / configuration.retargeting.policy_rate_hz)
    return {name: sections.get(name) for name in variants.SECTIONS} | {"decimation": decimation}


def _read_tasks(
    named: Mapping[str, str], folder: Path
) -> tuple[dict[str, dict[str, Any]], list[str]]:
    """What could be read of the names that keys hold, by name, and lines about the rest."""
    tasks, lines = {}, []
    for key, name in named.items():
        try:
            tasks[name] = read_task(key, name, folder)
        except ConfigurationError as error:
            lines += str(error).splitlines()
    return tasks, lines


def _error(lines: Sequence[str]) -> ConfigurationError:
    lines = list(lines)
    if len(lines) > MOST_LINES:
        lines = [*lines[:MOST_LINES], f"config: and {len(lines) - MOST_LINES} more such lines"]
    return ConfigurationError("\n".join(lines))
