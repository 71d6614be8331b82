"""What keys of a configuration must be in view of others."""

from collections.abc import Iterator, Mapping

from t2l.config import cloning, transfer_design
from t2l.config.actions import of_actions
from t2l.config.cells import grid_of, transfer_cells
from t2l.config.models import Configuration
from t2l.config.models.gain_search import GainSearchOfTask
from t2l.config.models.task_learning import LearnedTask
from t2l.gains import Cell
from t2l.hardware.motion import COMMAND_RATE_HZ
from t2l.policies import POLICIES
from t2l.rl.registry import ALGORITHMS
from t2l.sim.batch import TIMESTEP_S
from t2l.tasks import Demonstrated, Rewarded, Task
from t2l.tasks.pose_hold import PoseHold
from t2l.tasks.reach import EndEffectorReach
from t2l.tasks.task import OF_JOINTS
from t2l.transfer.deploy import LOG_RATE_HZ
from t2l.typed import Problem, describe, suggestion

SIMULATION_RATE_HZ = round(1 / TIMESTEP_S)
RECORDING_RATE_HZ = round(COMMAND_RATE_HZ)


def problems(configuration: Configuration, tasks: Mapping[str, Task]) -> list[Problem]:
    """Everything that is wrong between keys.

    Args:
        tasks: those of the study that could be made, by name.
    """
    return [
        *_regions(configuration),
        *_counts(configuration),
        *_rates(configuration, tasks),
        *cloning.problems(configuration, tasks),
        *_conditions(configuration, tasks),
        *transfer_design.decision(configuration, transfer_cells(configuration)),
        *transfer_design.ablation(configuration, transfer_cells(configuration)),
        *_weights(configuration, tasks),
        *_algorithm(configuration),
        *_workspace(configuration),
        *_scoreboard(configuration),
        *_decoupling(configuration, tasks),
        *_landscape(configuration),
        *_learning(configuration, tasks),
    ]


def _regions(configuration: Configuration) -> Iterator[Problem]:
    for key in ("grid", "recording_grid"):
        grid = grid_of(getattr(configuration, key))
        inside = [grid.in_compliant_overdamped(cell) for cell in grid.cells]
        if len(inside) > 1 and (all(inside) or not any(inside)):
            yield Problem(
                f"{key}.compliant_up_to_kp, {key}.overdamped_from_kd",
                f"{describe(grid.compliant_up_to_kp)}, {describe(grid.overdamped_from_kd)}, which "
                f"put {sum(inside)} of {len(inside)} cells into the compliant, overdamped region",
                "a split with at least one cell on either side",
            )


def _scoreboard(configuration: Configuration) -> Iterator[Problem]:
    section = configuration.scoreboard
    if section and configuration.study in section.studies:
        at = section.studies.index(configuration.study)
        yield Problem(f"scoreboard.studies[{at}]", describe(configuration.study), "another study")


def _counts(configuration: Configuration) -> Iterator[Problem]:
    count, training = configuration.demonstrations.count, configuration.training
    most = configuration.demonstrations.max_attempts
    if most < count:
        yield Problem(
            "demonstrations.max_attempts", str(most), f"at least demonstrations.count = {count}"
        )
    yield from _used(configuration)
    replays = configuration.fidelity.replays
    if replays > count:
        yield Problem("fidelity.replays", str(replays), f"at most demonstrations.count = {count}")
    executed = configuration.rollouts.executed_actions
    key = POLICIES.find(training.policy).chunk_setting
    if key and executed > getattr(training, key):
        allowed = f"at most training.{key} = {getattr(training, key)}"
        yield Problem("rollouts.executed_actions", str(executed), allowed)
    if round(training.validation_fraction * count) >= count:
        yield Problem(
            "training.validation_fraction",
            describe(training.validation_fraction),
            "a fraction that leaves demonstrations to train on",
        )


def _used(configuration: Configuration) -> Iterator[Problem]:
    section = configuration.demonstrations
    by_cell = section.used if isinstance(section.used, dict) else {}
    cells = [cell.name for cell in grid_of(configuration.grid).cells]
    for name in by_cell:
        if name not in cells:
            found = f"a cell that is not in the grid{suggestion(name, cells)}"
            yield Problem(f"demonstrations.used.{name}", found, ", ".join(cells))
    numbers = by_cell or {"": section.used}
    for name, used in numbers.items():
        if used is not None and used > section.count:
            key = f"demonstrations.used.{name}".removesuffix(".")
            yield Problem(key, str(used), f"at most demonstrations.count = {section.count}")


def _rates(configuration: Configuration, tasks: Mapping[str, Task]) -> Iterator[Problem]:
    rate = configuration.retargeting.policy_rate_hz
    if SIMULATION_RATE_HZ % rate:
        yield Problem(
            "retargeting.policy_rate_hz",
            describe(rate),
            f"a divisor of the simulation's {SIMULATION_RATE_HZ} Hz",
        )
    for name, task in tasks.items():
        if isinstance(task, Demonstrated) and task.horizon_s * rate < 1:
            yield Problem(
                "retargeting.policy_rate_hz",
                describe(rate),
                f"a rate with a step in the {task.horizon_s:g} s that {name} lasts",
            )
    physics = configuration.identification.rate_hz
    if physics % RECORDING_RATE_HZ:
        yield Problem(
            "identification.rate_hz",
            str(physics),
            f"a multiple of the recordings' {RECORDING_RATE_HZ} Hz",
        )


def _weights(configuration: Configuration, tasks: Mapping[str, Task]) -> Iterator[Problem]:
    """Weights of rewards that no task has which tuning may change."""
    known = set(EndEffectorReach.tuned)
    known.update(name for t in tasks.values() if isinstance(t, Rewarded) for name in t.tuned)
    for name in configuration.tuning.reward_weights:
        if name not in known:
            near = suggestion(name, sorted(known))
            yield Problem(
                f"tuning.reward_weights.{name}", f"a weight of no reward{near}", ", ".join(known)
            )


def _conditions(configuration: Configuration, tasks: Mapping[str, Task]) -> Iterator[Problem]:
    conditions = configuration.sim_to_real.conditions
    names = [condition.name for condition in conditions]
    cells = transfer_cells(configuration)
    robot = configuration.robot.name
    physics = configuration.identification.rate_hz
    for i, condition in enumerate(conditions):
        key = f"sim_to_real.conditions[{i}]"
        if condition.name in names[:i]:
            yield Problem(
                f"{key}.name", f"{condition.name!r} a second time", "names without repetitions"
            )
        task = tasks.get(condition.task)
        if task is not None and not isinstance(task, Rewarded):
            yield Problem(f"{key}.task", describe(condition.task), "a task with a reward")
        elif task is not None and task.robot.name != robot:
            yield Problem(
                f"{key}.task",
                f"{describe(condition.task)}, a task of {task.robot.name}",
                f"a task of robot.name = {robot}",
            )
        elif task is not None and not task.deployable:
            yield Problem(
                f"{key}.task",
                f"{describe(condition.task)}, which a robot's joints alone cannot do",
                "a task without objects and grippers; `learning` has the others",
            )
        yield from of_actions(f"{key}.actions", condition.actions, "joint_pd")
        yield from transfer_design.given_scales(key, condition, task, cells)
        rate = condition.policy_rate_hz
        if physics % rate or LOG_RATE_HZ % rate:
            yield Problem(
                f"{key}.policy_rate_hz",
                describe(rate),
                f"a divisor of {physics} (identification.rate_hz) and of {LOG_RATE_HZ:g}",
            )


def _decoupling(configuration: Configuration, tasks: Mapping[str, Task]) -> Iterator[Problem]:
    section = configuration.decoupling
    if section is None:
        return
    task = tasks.get(section.task)
    if task is not None and not isinstance(task, PoseHold):
        yield Problem("decoupling.task", describe(section.task), "a task of the kind pose_hold")
    names = [pairing.name for pairing in section.pairings]
    for i, pairing in enumerate(section.pairings):
        key = f"decoupling.pairings[{i}]"
        if pairing.name in names[:i]:
            yield Problem(
                f"{key}.name", f"{pairing.name!r} a second time", "names without repetitions"
            )
        yield from of_actions(f"{key}.actions", pairing.actions, "joint_pd")
    if section.evaluate_every > section.updates:
        yield Problem(
            "decoupling.evaluate_every",
            str(section.evaluate_every),
            f"at most decoupling.updates = {section.updates}",
        )


def _learning(configuration: Configuration, tasks: Mapping[str, Task]) -> Iterator[Problem]:
    section = configuration.learning
    if section is None:
        return
    if not (section.tasks or section.gain_searches):
        yield Problem("learning", "no task", "tasks under tasks or gain_searches")
    for of in "tasks", "gain_searches":
        entries = getattr(section, of)
        names = [entry.task for entry in entries]
        for i, entry in enumerate(entries):
            key, task = f"learning.{of}[{i}]", tasks.get(entry.task)
            if entry.task in names[:i]:
                yield Problem(f"{key}.task", f"{entry.task!r} a second time", "each task once")
            if task is not None and not isinstance(task, Rewarded):
                yield Problem(f"{key}.task", describe(entry.task), "a task with a reward")
                task = None
            yield from of_actions(f"{key}.actions", entry.actions, "joint_pd")
            if isinstance(entry, LearnedTask):
                yield from _of_cells(key, entry, task)
            elif entry.recordings and task is not None and task.beyond_joints:
                found = f"recordings for {entry.task}, which has {task.beyond_joints}"
                yield Problem(f"{key}.recordings", found, f"no recordings, or {OF_JOINTS}")
            yield from _of_training(key, entry, task)


def _of_cells(key: str, entry: LearnedTask, task: Rewarded | None) -> Iterator[Problem]:
    yield from transfer_design.scales(key, entry.action_scales, task)
    known = [Cell(given.kp, given.kd) for given in entry.action_scales]
    for j, searched in enumerate(entry.searched):
        cell = Cell(searched.kp, searched.kd)
        if cell in known:
            yield Problem(f"{key}.searched[{j}]", f"{cell} a second time", "each cell once")
        known.append(cell)
    if not known:
        yield Problem(key, "no cell", "cells under action_scales or searched")


def _of_training(
    key: str, entry: LearnedTask | GainSearchOfTask, task: Rewarded | None
) -> Iterator[Problem]:
    """Rates, and how often policies are judged."""
    if entry.rate_hz % entry.policy_rate_hz:
        yield Problem(
            f"{key}.policy_rate_hz",
            describe(entry.policy_rate_hz),
            f"a divisor of {key}.rate_hz = {entry.rate_hz:g}",
        )
    if task is not None and entry.rate_hz < task.least_rate_hz:
        yield Problem(
            f"{key}.rate_hz",
            describe(entry.rate_hz),
            f"from {task.least_rate_hz:g}, at which the contacts of {task.name} hold",
        )
    if entry.evaluate_every > entry.updates:
        found = str(entry.evaluate_every)
        yield Problem(f"{key}.evaluate_every", found, f"at most {key}.updates = {entry.updates}")


def _landscape(configuration: Configuration) -> Iterator[Problem]:
    if configuration.landscape is None:
        return
    conditions = configuration.sim_to_real.conditions
    if all(condition.action_scales for condition in conditions):
        yield Problem(
            "landscape",
            "this section, and no condition whose action scales are searched",
            "such a condition under sim_to_real.conditions",
        )


def _algorithm(configuration: Configuration) -> Iterator[Problem]:
    name, known = configuration.reinforcement_learning.algorithm, ALGORITHMS.names()
    if name not in known:
        found = describe(name) + suggestion(name, known)
        yield Problem("reinforcement_learning.algorithm", found, ", ".join(known))


def _workspace(configuration: Configuration) -> Iterator[Problem]:
    section = configuration.deployment
    lower, upper = "workspace_lower_m", "workspace_upper_m"
    # the key that was written; the other may be a default
    key, other, relation = (
        (lower, upper, "below") if lower in section.model_fields_set else (upper, lower, "above")
    )
    for axis, (low, high) in enumerate(
        zip(section.workspace_lower_m, section.workspace_upper_m, strict=True)
    ):
        if low >= high:
            found, limit = (low, high) if key == lower else (high, low)
            yield Problem(
                f"deployment.{key}[{axis}]",
                describe(found),
                f"a number {relation} {other}[{axis}] = {limit:g}",
            )
