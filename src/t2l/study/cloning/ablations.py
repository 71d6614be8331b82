"""Claims that behaviour cloning prefers the same gains whatever else is varied."""

import re
from dataclasses import replace
from functools import partial

import pandas as pd

from t2l.stats.scaling import COLUMNS, by_size, slopes
from t2l.stats.verdict import Finding, Verdict, every, greater
from t2l.study.claim import Claim
from t2l.study.cloning.claims import (
    CELLS,
    CO_REST,
    CO_REST_NULL,
    GRID,
    NOMINAL,
    TASK,
    co_beats_rest,
)
from t2l.study.evidence import AbsentError, Evidence
from t2l.study.published.numbers import Published, splits
from t2l.study.words import among

# a claim: what is varied, the variant of cloning, and the study of ours that trains it
SIZED = "demonstrations"
VARIANTS = {
    "ablation_regression": ("policies that regress", "regression", "policy_classes"),
    "ablation_diffusion": ("diffusion policies", "diffusion", "policy_classes"),
    "ablation_transformer": ("Transformers", "transformer", "policy_classes"),
    "ablation_lerobot_act": ("ACT, as lerobot has it", "lerobot_act", "lerobot_policies"),
    "ablation_lerobot_diffusion": (
        "Diffusion Policy, as lerobot has it",
        "lerobot_diffusion",
        "lerobot_policies",
    ),
    "ablation_history": ("policies without a history of observations", "history_1", "variants"),
    "ablation_chunk": ("single actions instead of chunks", "chunk_1", "ablations"),
    "ablation_joint_delta": ("joint changes as actions", "joint_deltas", "ablations"),
    "ablation_task_space": ("task-space control", "task_space", "ablations"),
    "ablation_10_hz": ("policies at 10 Hz", "rate_10_hz", "ablations"),
    "ablation_50_demonstrations": ("50 demonstrations", "demonstrations_50", SIZED),
    "ablation_900_demonstrations": ("900 demonstrations", "demonstrations_900", SIZED),
}
# a policy's classes, the nominal's autoencoder first: variants and the studies of ours about them
CLASSES = {NOMINAL: GRID} | {
    variant: study
    for _, variant, study in VARIANTS.values()
    if study in ("policy_classes", "lerobot_policies")
}
FEWEST_SIZES = 3  # two would fit any line
SIZES = re.compile(r"demonstrations_\d+")


def _scaling(evidence: Evidence, published: Published, tests: int) -> Finding:
    sizes = _sizes(evidence)
    if len(sizes) < FEWEST_SIZES:
        raise AbsentError(f"no {FEWEST_SIZES} numbers of demonstrations")
    table = by_size(pd.concat(sizes.values()))
    kp, kd = table.index.to_frame().to_numpy().T
    co, slope = splits()["cloning"].regions(kp, kd) == "CO", slopes(table)
    found = greater(slope[co], slope[~co], tests=tests)
    return among(found, "{:+.3f} and {:+.3f} per doubling", slope[co], slope[~co])


def _sizes(evidence: Evidence) -> dict[int, pd.DataFrame]:
    """Policies by how many demonstrations they were trained on; trained alike but for it."""
    names = filter(SIZES.fullmatch, evidence.names("cloning", "variant"))
    tables = [
        evidence.table("cloning", COLUMNS, task=TASK, variant=name) for name in (NOMINAL, *names)
    ]
    return {int(table.demonstrations.max()): table for table in tables}


def _persists(key: str, what: str, variant: str, study: str) -> Claim:
    statement = f"With {what}, compliant, overdamped gains still succeed more often."
    return Claim(key, statement, CELLS, CO_REST, CO_REST_NULL, co_beats_rest(variant), about=study)


def _every_class(evidence: Evidence, published: Published, tests: int) -> Finding:
    """Whether each class prefers CO; one that was not run leaves open what the others hold."""
    run = {}
    for variant, study in CLASSES.items():
        judge = partial(co_beats_rest(variant), published=published, tests=tests)
        try:
            run[variant] = evidence.of_one(study, judge)
        except AbsentError:
            continue
    if run.keys() <= {NOMINAL}:
        raise AbsentError("no class of policies but the nominal's")
    missing = [Finding(Verdict.CANNOT_TELL)] * (len(CLASSES) - len(run))
    found = every([*run.values(), *missing])
    held = sum(one.verdict is Verdict.REPRODUCED for one in run.values())
    ours = f"in {held} of {len(run)} classes" + (f", {len(missing)} not run" if missing else "")
    return replace(found, n=min(one.n for one in run.values()), ours=ours)


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
        CELLS,
        CO_REST,
        CO_REST_NULL,
        co_beats_rest("images"),
        about="pictures",
    ),
    Claim(
        "ablation_no_gravity_compensation",
        "Without gravity compensation, compliant, overdamped gains still succeed more often.",
        CELLS,
        CO_REST,
        CO_REST_NULL,
        co_beats_rest(task=f"{TASK}_no_gravity_compensation"),
        about="no_gravity_compensation",
    ),
    Claim(
        "another_robot",
        "On a UR, compliant, overdamped gains succeed more often.",
        CELLS,
        CO_REST,
        CO_REST_NULL,
        co_beats_rest(task=f"{TASK}_ur5e"),
        about="ur5e",
    ),
    Claim(
        "scaling",
        "Success grows faster with the number of demonstrations at compliant, overdamped gains.",
        CELLS,
        "slope of success per doubling, cells in CO against all others, one-sided Mann-Whitney",
        "the slope in CO is not greater than outside",
        _scaling,
        about=SIZED,
    ),
]
