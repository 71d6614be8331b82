"""Whether a study of transfer can be run as it is asked for, and can answer its own question."""

from collections.abc import Iterator, Mapping, Sequence

from t2l.config.models import Configuration
from t2l.config.models.experiment import Condition, GivenScale
from t2l.errors import ConfigurationError
from t2l.gains import Cell
from t2l.hardware import find_backend
from t2l.stats.attainable import least_attainable_p
from t2l.study.transfer.rule import Rule
from t2l.tasks import Rewarded, Task
from t2l.typed import Invalid, Problem, describe, suggestion


def given_scales(
    key: str, condition: Condition, task: Task | None, cells: Sequence[Cell]
) -> Iterator[Problem]:
    """What is wrong with the action scales that a condition is given."""
    for i, entry in enumerate(condition.action_scales):
        cell = Cell(entry.kp, entry.kd)
        if cell not in cells:
            yield Problem(
                f"{key}.action_scales[{i}]", str(cell), "a cell of recording_grid that is run"
            )
    yield from scales(key, condition.action_scales, task)


def scales(key: str, entries: Sequence[GivenScale], task: Task | None) -> Iterator[Problem]:
    """What is wrong with action scales of cells, whatever the cells are of."""
    seen = set()
    for i, entry in enumerate(entries):
        cell = Cell(entry.kp, entry.kd)
        if cell in seen:
            yield Problem(f"{key}.action_scales[{i}]", f"{cell} a second time", "each cell once")
        seen.add(cell)
        groups = task.robot.scale_groups if isinstance(task, Rewarded) else entry.rad
        if len(entry.rad) != len(groups):
            yield Problem(
                f"{key}.action_scales[{i}].rad",
                f"a list of {len(entry.rad)}",
                f"one for each of {', '.join(groups)}",
            )


def decision(configuration: Configuration, cells: Sequence[Cell]) -> Iterator[Problem]:
    """Why a study cannot decide by its own rule, whatever it finds."""
    section = configuration.transfer_decision
    if section is None:
        return
    rule, key = Rule(**section.model_dump()), "transfer_decision"
    conditions: Mapping[str, Condition] = {c.name: c for c in configuration.sim_to_real.conditions}
    if rule.condition not in conditions:
        names = list(conditions)
        found = describe(rule.condition) + suggestion(rule.condition, names)
        yield Problem(f"{key}.condition", found, ", ".join(names) or "a condition; there is none")
        return
    given = {Cell(e.kp, e.kd) for e in conditions[rule.condition].action_scales}
    cells = [cell for cell in cells if not given or cell in given]
    if len(cells) < rule.cells:
        yield Problem(
            f"{key}.cells",
            f"{rule.cells}, and {len(cells)} cells of {rule.condition} that are run",
            f"at most {len(cells)}, or more cells (recording_grid, sim_to_real.cells)",
        )
    if configuration.sim_to_real.seeds < rule.seeds:
        yield Problem(
            "sim_to_real.seeds",
            str(configuration.sim_to_real.seeds),
            f"at least {key}.seeds = {rule.seeds}",
        )
    inside = int(rule.inside([c.kp for c in cells], [c.kd for c in cells]).sum())
    outside = len(cells) - inside
    least = least_attainable_p(inside, outside)
    if least > rule.alpha:
        p = f"whose least attainable p is {least:.2g}" if inside and outside else "no comparison"
        yield Problem(
            f"{key}.stiff_from_kp, {key}.overdamped_from_kd",
            f"{inside} cells inside and {outside} outside of the region: {p}",
            f"a split, and so many cells, that p can be {rule.alpha:g}",
        )
    if min(len({c.kp for c in cells}), len({c.kd for c in cells})) < 2:
        yield Problem(
            f"{key}.condition", "cells with one stiffness or one damping", "two of each at least"
        )


def ablation(configuration: Configuration, cells: Sequence[Cell]) -> Iterator[Problem]:
    """What of an ablation of the robot cannot be run."""
    section, key = configuration.robot_ablation, "robot_ablation"
    if section is None:
        return
    conditions = {c.name: c for c in configuration.sim_to_real.conditions}
    if section.condition not in conditions:
        found = describe(section.condition) + suggestion(section.condition, list(conditions))
        yield Problem(f"{key}.condition", found, ", ".join(conditions) or "a condition")
        return
    given = {Cell(e.kp, e.kd) for e in conditions[section.condition].action_scales}
    for i, entry in enumerate(section.cells):
        cell = Cell(entry.kp, entry.kd)
        if cell not in cells or (given and cell not in given):
            allowed = f"a cell of {section.condition} that is run"
            yield Problem(f"{key}.cells[{i}]", str(cell), allowed)
    robot = configuration.robot.model_dump(exclude_none=True)
    for i, effect in enumerate(section.effects):
        try:
            find_backend({**robot, "without": [effect]})
        except Invalid as error:
            problem = error.problems[0]
            allowed = f"{problem.allowed}, of robot.backend = {robot['backend']}"
            yield Problem(f"{key}.effects[{i}]", describe(effect), allowed)
        except ConfigurationError:
            return  # the section `robot` is wrong, which is told elsewhere
