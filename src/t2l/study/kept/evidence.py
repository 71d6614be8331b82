"""The evidence that a repository keeps: tables of docs/data, in the shapes that claims read.

A kept table has one row a policy or a cell where the results have one a rollout. Shares become
that many rollouts again; of errors each gets the mean, which is all that a rule looks at.
"""

from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path

import numpy as np
import pandas as pd

from t2l.bc.collections import collection
from t2l.names import heading
from t2l.study.cloning.claims import ANEW_TASKS, OF_COLLECTIONS, TASK
from t2l.study.evidence import Evidence, Source, source_of
from t2l.study.transfer.decision import decide
from t2l.study.transfer.rule import Rule

HOLD_S = 0.02  # of policies at 50 Hz, as in every grid
Shaped = Iterator[tuple[str, pd.DataFrame]]  # where below results/ a table would lie, and the table
RATES = {10: "joint_reach_10_hz", 20: "joint_reach_20_hz", 50: "joint_reach",
         100: "joint_reach_100_hz"}  # fmt: skip

# variants of the collections, as pages and figures tell them
LENGTHS = {"epochs_50": "50 epochs", "nominal": "150 epochs", "epochs_400": "400 epochs"}
OF_BLOCKS = {
    "observation_noise_0": "no noise on observations",
    "demonstrations_900": "900 demonstrations",
}
ANEW = {
    (task, variant): f"{heading(task)}, {words}"
    for task in (TASK, *ANEW_TASKS)
    for variant, words in (LENGTHS | (OF_BLOCKS if task == TASK else {})).items()
}


def evidence(folder: Path, rule: Rule) -> Evidence:
    """What is kept in a folder such as docs/data.

    Args:
        rule: of the registered decision on transfer.
    """
    found: list[tuple[Source, pd.DataFrame]] = []
    for name, shape in FILES.items():
        for path, table in shape(pd.read_csv(folder / f"{name}.csv")):
            source = source_of(f"results/{path}")
            assert source is not None, path
            found.append((source, table))
    policies = _nominal(pd.read_csv(folder / "transfer_decision.csv"))
    decided = decide(deployed(policies), policies, rule)
    source = source_of(f"results/transfer_decision/tables/transfer_decision_{rule.condition}.csv")
    assert source is not None
    return Evidence([*found, (source, decided)])


def _cloning(table: pd.DataFrame, study: str, task: str) -> Shaped:
    for variant, rows in table.groupby("variant"):
        yield f"{study}/{task}/{variant}/cells.parquet", rows


def named_collections(table: pd.DataFrame) -> dict[str, pd.DataFrame]:
    """Policies of collections that were drawn anew, by the words for their task and variant."""
    found = dict(iter(table.groupby(["task", "variant"])))
    return {words: found[names] for names, words in ANEW.items() if names in found}


def _collections(table: pd.DataFrame) -> Shaped:
    for (task, variant, number), rows in table.groupby(["task", "variant", "collection"]):
        own = collection(task, int(number))
        # a study of its own, as its demonstrations are others
        apart = variant == "demonstrations_900"
        study, variant = (
            ("collections_900", "nominal") if apart else (OF_COLLECTIONS[task], variant)
        )
        yield f"{study}/{own}/{variant}/cells.parquet", rows


def _ablations(table: pd.DataFrame) -> Shaped:
    apart = "no_gravity_compensation"
    yield from _cloning(table[table.variant != apart], "ablations", "block_stack")
    own = table[table.variant == apart]
    yield f"{apart}/block_stack_{apart}/nominal/cells.parquet", own


def demonstrations(table: pd.DataFrame) -> pd.DataFrame:
    """With the number of demonstrations as a column, which the name of a variant says."""
    return table.assign(
        demonstrations=table.variant.str.removeprefix("demonstrations_").astype(int)
    )


def _demonstrations(table: pd.DataFrame) -> Shaped:
    named = table.variant.replace("demonstrations_100", "nominal")
    yield from _cloning(
        demonstrations(table).assign(variant=named), "demonstrations", "block_stack"
    )


def replays(table: pd.DataFrame) -> pd.DataFrame:
    """A row a replay: as many succeed as did; each has the mean error."""
    rows = table.loc[table.index.repeat(table.replays)]
    number = rows.groupby(level=0).cumcount()
    return rows.assign(success=number < (rows.success * rows.replays).round())


def _fidelity(table: pd.DataFrame) -> Shaped:
    for (kp, kd), cell in replays(table).groupby(["kp", "kd"]):
        yield f"cloning_grid/block_stack/fidelity/kp{kp}_kd{kd}.parquet", cell


def _noise(table: pd.DataFrame) -> Shaped:
    path = "cloning_grid/block_stack/noise/kp32_kd1/noisy_replays.parquet"
    yield path, table.rename(columns={"mean": "success"})


def _variance(table: pd.DataFrame) -> Shaped:
    yield "cloning_grid/attenuation/held_noise.parquet", table


def _following(table: pd.DataFrame) -> Shaped:
    yield "recorded/following/joints.parquet", table


def _decoupling(table: pd.DataFrame) -> Shaped:
    yield "decoupling_swept/decoupling/trainings.parquet", table


def _landscape(table: pd.DataFrame) -> Shaped:
    for (kp, kd), cell in table.groupby(["kp", "kd"]):
        yield f"landscape/sim_to_real/joint_reach/kp{kp:g}_kd{kd:g}/trials.parquet", cell


def _again(table: pd.DataFrame) -> Shaped:
    for (kp, kd), cell in table.groupby(["kp", "kd"]):
        folder = f"landscape/sim_to_real/joint_reach/kp{kp:g}_kd{kd:g}/again"
        yield f"{folder}/1_seed1.parquet", cell


def _learned(table: pd.DataFrame) -> Shaped:
    yield "existence/learning/policies.parquet", table


def _nominal(table: pd.DataFrame) -> pd.DataFrame:
    """Policies on the whole robot."""
    return table[table.without.isna()]


def deployed(policies: pd.DataFrame) -> pd.DataFrame:
    """As many rollouts of each policy as there were: so many stopped, so many that jitter.

    Each has the policy's mean errors, so that means over rollouts are those of the results.
    """
    rows = policies.loc[policies.index.repeat(policies.rollouts)]
    number = rows.groupby(level=0).cumcount()
    made = {}
    for suffix in ("", "_sim"):
        stopped, jitter = (
            (rows[f"{name}_rate{suffix}"] * rows.rollouts).round() for name in ("stopped", "jitter")
        )
        made[f"stopped{suffix}"] = np.where(number < stopped, "stopped", "")
        made[f"jitter_failure{suffix}"] = (number >= stopped) & (number < stopped + jitter)
    return rows.assign(**made)


def _condition(policies: pd.DataFrame, study: str, condition: str) -> Shaped:
    folder = f"{study}/sim_to_real/{condition}"
    yield f"{folder}/cells.parquet", policies
    yield f"{folder}/rollouts.parquet", deployed(policies)


def _decision(table: pd.DataFrame) -> Shaped:
    yield from _condition(_nominal(table), "transfer_decision", "joint_reach")


def _rates(table: pd.DataFrame) -> Shaped:
    for hertz, policies in table.groupby("policy_rate_hz"):
        yield from _condition(policies, "transfer_rates", RATES[int(hertz)])


def _identification(table: pd.DataFrame) -> Shaped:
    for study, cells in table.groupby("study"):
        yield f"{study}/sim_to_real/identification.parquet", cells


def _of(study: str, task: str) -> Callable[[pd.DataFrame], Shaped]:
    return partial(_cloning, study=study, task=task)


# by name of the file
FILES: dict[str, Callable[[pd.DataFrame], Shaped]] = {
    "cloning_grid": _of("cloning_grid", "block_stack"),
    "collections": _collections,
    "bimanual_handover": _of("bimanual_handover", "bimanual_handover"),
    "dishrack_loading": _of("dishrack", "dishrack_loading"),
    "dishrack_unloading": _of("dishrack", "dishrack_unloading"),
    "dishwasher": _of("dishwasher", "dishwasher"),
    "mug_hanging": _of("mug_hanging", "mug_hanging"),
    "ur5e": _of("ur5e", "block_stack_ur5e"),
    "policy_classes": _of("policy_classes", "block_stack"),
    "lerobot_policies": _of("lerobot_policies", "block_stack"),
    "pictures": _of("pictures", "block_stack"),
    "variants": _of("variants", "block_stack"),
    "end_to_end": _of("end_to_end", "block_stack_teleoperated"),
    "ablations": _ablations,
    "demonstrations": _demonstrations,
    "fidelity": _fidelity,
    "noisy_replays": _noise,
    "held_noise": _variance,
    "following": _following,
    "decoupling": _decoupling,
    "existence": _learned,
    "landscape": _landscape,
    "landscape_again": _again,
    "transfer_decision": _decision,
    "transfer_rates": _rates,
    "identification": _identification,
}
