"""Tables of the documentation, made of those that the repository keeps."""

from collections.abc import Iterator
from pathlib import Path

import pandas as pd

from t2l.names import heading, with_minus
from t2l.sim.batch import TIMESTEP_S
from t2l.stats.collections import best_elsewhere, collections_table, printable_collections
from t2l.stats.regions import printable_regions, region_table
from t2l.stats.text import p_value, rate
from t2l.stats.transfer import jitter_table, printable_jitter
from t2l.study.attenuation.ranking import beforehand_table, printable_beforehand
from t2l.study.attenuation.statistics import effective_error_table, printable_effective_error
from t2l.study.attenuation.success import by_cell
from t2l.study.cloning.claims import ANEW_TASKS, TASK
from t2l.study.decoupling.statistics import decoupling_table, printable_decoupling
from t2l.study.decoupling.summary import chosen
from t2l.study.kept.evidence import HOLD_S, LENGTHS, deployed, named_collections
from t2l.study.published.numbers import grid_of
from t2l.study.transfer.decision import decide, printable_decision
from t2l.study.transfer.rule import Rule

Tables = Iterator[tuple[str, pd.DataFrame, pd.DataFrame]]  # a name, the numbers, and as text
# of tables that have a row a policy
CLONED = (
    "cloning_grid", "bimanual_handover", "dishrack_loading", "dishrack_unloading", "dishwasher",
    "mug_hanging", "ur5e", "ablations", "policy_classes", "lerobot_policies", "demonstrations",
    "variants",
)  # fmt: skip
# grids that rows of the scoreboard compare CO in: a file and a variant each
COMPARED = {
    "Block Stack": ("cloning_grid", "nominal"),
    "Dishrack, loading": ("dishrack_loading", "nominal"),
    "Dishrack, unloading": ("dishrack_unloading", "nominal"),
    "Handover of two arms": ("bimanual_handover", "nominal"),
    "Mug": ("mug_hanging", "nominal"),
    "Dishwasher": ("dishwasher", "nominal"),
    "Block Stack, UR5e": ("ur5e", "nominal"),
    "regression": ("policy_classes", "regression"),
    "diffusion": ("policy_classes", "diffusion"),
    "Transformer": ("policy_classes", "transformer"),
    "lerobot's ACT": ("lerobot_policies", "lerobot_act"),
    "lerobot's Diffusion Policy": ("lerobot_policies", "lerobot_diffusion"),
    "no history": ("variants", "history_1"),
    "single actions": ("ablations", "chunk_1"),
    "joint deltas": ("ablations", "joint_deltas"),
    "task-space control": ("ablations", "task_space"),
    "10 Hz": ("ablations", "rate_10_hz"),
    "no gravity compensation": ("ablations", "no_gravity_compensation"),
    "50 demonstrations": ("demonstrations", "demonstrations_50"),
    "900 demonstrations": ("demonstrations", "demonstrations_900"),
}
GRIDS = (*CLONED[:7],)
FORESEEN = {"block_stack": "cloning_grid"}  # tasks whose grid has another name


def tables(folder: Path, rule: Rule) -> Tables:
    """Each table by its name.

    Args:
        folder: docs/data.
    """

    def read(name: str) -> pd.DataFrame:
        return pd.read_csv(folder / f"{name}.csv")

    for name in CLONED:
        policies = read(name)
        variants = {str(key): rows for key, rows in policies.groupby("variant", sort=False)}
        table = region_table(variants, grid_of(policies, "cloning"))
        yield f"{name}_regions", table, printable_regions(table)
    grids = {name: read(name).query("variant == 'nominal'") for name in GRIDS}
    table = effective_error_table({name: by_cell(rows) for name, rows in grids.items()}, HOLD_S)
    yield "effective_error", table, printable_effective_error(table)
    foreseen = read("label_residuals")
    for kind, joints in foreseen.groupby("labels", sort=False):
        cells = {task: by_cell(grids[FORESEEN.get(task, task)]) for task in joints.task.unique()}
        table = beforehand_table(cells, joints, TIMESTEP_S, HOLD_S)
        yield f"beforehand_{kind}", table, printable_beforehand(table)
    policies = read("transfer_decision").query("without.isna()")
    table = decide(deployed(policies), policies, rule)
    yield "transfer_decision", table, printable_decision(table)
    rates = {str(hertz): rows for hertz, rows in read("transfer_rates").groupby("policy_rate_hz")}
    table = jitter_table(
        {name: deployed(rows) for name, rows in rates.items()},
        {name: float(name) for name in rates},
    )
    yield "jitter", table, printable_jitter(table)
    table = compliance(folder)
    yield "compliance", table, printable_compliance(table)
    table = collections(folder)
    yield "collections", table, printable_collections(table)
    trainings = chosen(read("decoupling"))
    table = decoupling_table(trainings, list(dict.fromkeys(trainings.pairing)))
    yield "decoupling", table, printable_decoupling(table)


def collections(folder: Path) -> pd.DataFrame:
    """`t2l.stats.collections.collections_table` of what is kept in docs/data."""
    policies = pd.read_csv(folder / "collections.csv")
    rows = {}
    for task in (TASK, *ANEW_TASKS):
        of_task = policies[policies.task == task]
        lengths = {
            variant: own for variant, own in of_task.groupby("variant") if variant in LENGTHS
        }
        rows |= named_collections(of_task)
        if len(lengths) == len(LENGTHS):
            rows[f"{heading(task)}, each cell's best length"] = best_elsewhere(lengths)
    return collections_table(rows, grid_of(policies, "cloning"))


def compliance(folder: Path) -> pd.DataFrame:
    """CO against SO, which damping alone does not tell apart, in each grid that rows are judged by.

    Returns:
        A row a grid: name, cells of both regions, success_co, success_so, p_co_so.
    """
    rows = []
    for words, (name, variant) in COMPARED.items():
        policies = pd.read_csv(folder / f"{name}.csv")
        policies = policies[policies.variant == variant]
        rows.append(region_table({words: policies}, grid_of(policies, "cloning")))
    return pd.concat(rows, ignore_index=True)


def printable_compliance(table: pd.DataFrame) -> pd.DataFrame:
    """`compliance` as text."""
    both = zip(table.cells_co, table.cells_so, strict=True)
    more = 100 * (table.success_co - table.success_so)
    return pd.DataFrame(
        {
            "CO against SO": table.name,
            "Cells": [f"{co} and {so}" for co, so in both],
            "CO": [rate(value) for value in table.success_co],
            "SO": [rate(value) for value in table.success_so],
            "Points": [with_minus(f"{round(value):+d}") for value in more],
            "p (CO > SO)": [p_value(p) for p in table.p_co_so],
        }
    )
