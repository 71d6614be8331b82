"""Claims that behaviour cloning prefers the same gains whatever else is varied."""

import re
from dataclasses import replace

import numpy as np
import pandas as pd

from t2l.published.numbers import Published, splits
from t2l.scoreboard.claim import Claim
from t2l.scoreboard.cloning import (
    CELLS,
    CO_REST,
    CO_REST_NULL,
    NOMINAL,
    TASK,
    cells_of,
    co_beats_rest,
)
from t2l.scoreboard.evidence import AbsentError, Evidence
from t2l.scoreboard.words import among, percents
from t2l.stats.verdict import Finding, Verdict, every, greater, paired_greater

# a claim, what is varied, and the variant of cloning that a study calls so
VARIANTS = {
    "ablation_regression": ("policies that regress", "regression"),
    "ablation_diffusion": ("diffusion policies", "diffusion"),
    "ablation_transformer": ("Transformers", "transformer"),
    "ablation_lerobot_act": ("ACT, as lerobot has it", "lerobot_act"),
    "ablation_lerobot_diffusion": ("Diffusion Policy, as lerobot has it", "lerobot_diffusion"),
    "ablation_history": ("policies without a history of observations", "history_1"),
    "ablation_chunk": ("single actions instead of chunks", "chunk_1"),
    "ablation_joint_delta": ("joint changes as actions", "joint_deltas"),
    "ablation_task_space": ("task-space control", "task_space"),
    "ablation_10_hz": ("policies at 10 Hz", "rate_10_hz"),
    "ablation_50_demonstrations": ("50 demonstrations", "demonstrations_50"),
    "ablation_900_demonstrations": ("900 demonstrations", "demonstrations_900"),
}
# a policy's classes, the nominal's autoencoder first
CLASSES = (
    NOMINAL,
    *(VARIANTS[f"ablation_{name}"][1] for name in ("regression", "diffusion", "transformer")),
    *(VARIANTS[f"ablation_lerobot_{name}"][1] for name in ("act", "diffusion")),
)
SIZES = re.compile(r"demonstrations_(\d+)")
FEWEST_SIZES = 3  # two would fit any line


def slopes(success: pd.DataFrame) -> np.ndarray:
    """(n,) change of success per doubling of the demonstrations, least squares a cell.

    Args:
        success: a row a cell, a column a number of demonstrations.
    """
    x = np.log2(np.asarray(success.columns, float))
    x = x - x.mean()
    return (success.to_numpy() @ x) / (x @ x)


def _scaling(evidence: Evidence, published: Published, tests: int) -> Finding:
    for study in evidence.studies:
        own = evidence.only(study)
        sizes = _sizes(own)
        if len(sizes) >= FEWEST_SIZES:
            break
    else:
        raise AbsentError(f"no study with {FEWEST_SIZES} numbers of demonstrations")
    rows = pd.concat([cells_of(own, name).assign(size=n) for n, name in sizes.items()])
    table = rows.pivot(index=["region", "kp", "kd"], columns="size", values="success").dropna()
    co = table.index.get_level_values("region") == "CO"
    slope = slopes(table)
    found = greater(slope[co], slope[~co], tests=tests)
    return among(found, "{:+.3f} and {:+.3f} per doubling", slope[co], slope[~co])


def _sizes(evidence: Evidence) -> dict[int, str]:
    """Variants of a study by their number of demonstrations; trained alike but for it."""
    try:
        nominal = evidence.table("cloning", ("replays",), task=TASK, variant=NOMINAL)
    except AbsentError:
        return {}
    # the nominal replays every demonstration once
    return {int(nominal.replays.max()): NOMINAL} | {
        int(match[1]): name
        for name in evidence.names("cloning", "variant")
        if (match := SIZES.fullmatch(name))
    }


def _persists(key: str, what: str, variant: str) -> Claim:
    statement = f"With {what}, compliant, overdamped gains still succeed more often."
    return Claim(key, statement, CELLS, CO_REST, CO_REST_NULL, co_beats_rest(variant))


def _every_class(evidence: Evidence, published: Published, tests: int) -> Finding:
    """Whether each class prefers CO; one that was not run leaves open what the others hold."""
    run = {}
    for variant in CLASSES:
        try:
            run[variant] = co_beats_rest(variant)(evidence, published, tests)
        except AbsentError:
            continue
    if run.keys() <= {NOMINAL}:
        raise AbsentError("no class of policies but the nominal's")
    missing = [Finding(Verdict.CANNOT_TELL)] * (len(CLASSES) - len(run))
    found = every([*run.values(), *missing])
    held = sum(one.verdict is Verdict.REPRODUCED for one in run.values())
    ours = f"in {held} of {len(run)} classes" + (f", {len(missing)} not run" if missing else "")
    return replace(found, n=min(one.n for one in run.values()), ours=ours)


def _images(evidence: Evidence, published: Published, tests: int) -> Finding:
    """At the corners of the grid and its centre: the margin of CO over all others, of each seed."""
    columns = ("kp", "kd", "seed", "success")
    table = evidence.table("cloning", columns, task=TASK, variant="images")
    co = splits()["cloning"].regions(table.kp, table.kd) == "CO"
    inside, outside = (part.groupby("seed").success.mean() for part in (table[co], table[~co]))
    margin = (inside - outside).dropna()
    if margin.empty:
        raise AbsentError("no training seed with cells inside and outside of CO")
    return percents(paired_greater(margin.to_numpy(), tests=tests), inside, outside)


CLAIMS = [
    *(_persists(key, *names) for key, names in VARIANTS.items()),
    Claim(
        "ablation_classes",
        "With every class of policies, compliant, overdamped gains succeed more often.",
        CELLS,
        f"{CO_REST}, in each class; the greatest p. Not reproduced where it is not in one that "
        f"was run, reproduced where it is in all of {', '.join(CLASSES)}. n is of the smallest",
        "in one class at least, success in CO is not greater than outside",
        _every_class,
    ),
    Claim(
        "ablation_images",
        "With images instead of states, compliant, overdamped gains still succeed more often.",
        "training seed",
        "success of policies in CO less the mean of all others, within seeds, one-sided sign-flip",
        "success in CO is not greater than outside",
        _images,
    ),
    Claim(
        "ablation_no_gravity_compensation",
        "Without gravity compensation, compliant, overdamped gains still succeed more often.",
        CELLS,
        CO_REST,
        CO_REST_NULL,
        co_beats_rest(task=f"{TASK}_no_gravity_compensation"),
    ),
    Claim(
        "another_robot",
        "On a UR, compliant, overdamped gains succeed more often.",
        CELLS,
        CO_REST,
        CO_REST_NULL,
        co_beats_rest(task=f"{TASK}_ur5e"),
    ),
    Claim(
        "scaling",
        "Success grows faster with the number of demonstrations at compliant, overdamped gains.",
        CELLS,
        "slope of success per doubling, cells in CO against all others, one-sided Mann-Whitney",
        "the slope in CO is not greater than outside",
        _scaling,
    ),
    Claim("stiff_datasets", "Large public data sets were recorded with stiff gains."),
]
