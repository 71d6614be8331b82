"""Claims about behaviour cloning: retargeting, regions of gains, losses."""

from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import replace
from functools import partial

import numpy as np
import pandas as pd

from t2l.stats.collections import (
    COLUMNS,
    FEWEST,
    UNIT,
    by_collection,
    contrast,
    over_collections,
    slopes,
)
from t2l.stats.rank import spearman
from t2l.stats.regions import REGIONS, by_cell
from t2l.stats.slopes import share_slopes
from t2l.stats.verdict import (
    Finding,
    Verdict,
    correlated,
    every,
    every_at_most,
    greater,
    paired_greater,
    shares_at_least,
    signed,
)
from t2l.study.both_slopes import both_slopes
from t2l.study.claim import Claim, Judge
from t2l.study.evidence import AbsentError, Evidence
from t2l.study.published.numbers import Published, grid_of, splits
from t2l.study.words import among, cannot_tell, percents

TASK, NOMINAL = "block_stack", "nominal"
# of demonstrations that are collected in each cell
OPERATED_TASK, OPERATED = "block_stack_teleoperated", "operator"
GRID = "cloning_grid"  # the study of ours that trains the nominal in every cell
# the paper's, for as many of which it corrects its p, and the study of ours about each
STUDY_TASKS = {
    TASK: GRID,
    "bimanual_handover": "bimanual_handover",
    "dishrack_unloading": "dishrack",
    "dishrack_loading": "dishrack",
    "dishwasher": "dishwasher",
    "mug_hanging": "mug_hanging",
}
CELLS = "cell (mean over training seeds)"
ANEW = "collections"  # the study of ours with several
# tasks of another one: all others
ANEW_TASKS = tuple(task for task in STUDY_TASKS if task != TASK)
OF_COLLECTIONS = {TASK: ANEW} | dict.fromkeys(ANEW_TASKS, "collections_tasks")
# how a rule goes on
OR_COLLECTIONS = (
    "; with five collections or more these are the unit, and their 95 % interval decides"
)
LOSS = "validation_mse_rad2"
CO_REST = "success of cells in CO against all others, one-sided Mann-Whitney"
CO_REST_NULL = "success in CO is not greater than outside"
SIMULATION_RATE_HZ = 500
WORKS = 0.1  # statistics: success of the best cell, below which none tells one gain from another


def cells_of(
    evidence: Evidence, variant: str = NOMINAL, task: str = TASK, *more: str
) -> pd.DataFrame:
    """One row a cell: kp, kd, seeds, rollouts, successes, success, region, means of `more`."""
    columns = ("kp", "kd", "success", "rollouts", *more)
    table = evidence.table("cloning", columns, task=task, variant=variant)
    cells = by_cell(table)
    for column in more:
        means = table.groupby(["kp", "kd"], as_index=False)[column].mean()
        cells = cells.merge(means, on=["kp", "kd"])
    return cells.assign(region=splits()["cloning"].regions(cells.kp, cells.kd))


def _of_every_collection(evidence: Evidence, variant: str, task: str, *more: str) -> pd.DataFrame:
    """A row a policy, with its collection, counted from 0."""
    columns, named = (*COLUMNS[1:], *more), {"task": task, "variant": variant}
    first = evidence.table("cloning", columns, **named)
    tables = [first if "collection" in first else first.assign(collection=0)]
    for number in evidence.names("anew", "number"):
        with suppress(AbsentError):
            own = evidence.table("anew", columns, number=number, **named)
            tables.append(own.assign(collection=int(number)))
    return pd.concat(tables)


def anew(
    evidence: Evidence, variant: str = NOMINAL, task: str = TASK, *more: str
) -> pd.DataFrame | None:
    """Cells of each collection, as `by_collection` has them; None where these are too few."""
    cells = _of_every_collection(evidence, variant, task, *more)
    own = by_collection(cells, grid_of(cells, "cloning"), *more)
    return own if own.collection.nunique() >= FEWEST else None


def of_each(
    own: pd.DataFrame, number: Callable[[pd.DataFrame], float], sign: int, tests: int
) -> Finding:
    """Whether a number of each collection's cells has the claimed sign."""
    values = [float(number(cells)) for _, cells in own.groupby("collection")]
    return over_collections(np.array(values), sign, tests)


def _over_collections(own: pd.DataFrame, outside: Sequence[str], tests: int) -> Finding:
    """CO against other regions, with the collection as the unit."""
    if own.groupby(["kp", "kd"]).success.mean().max() < WORKS:
        nothing = Finding(Verdict.CANNOT_TELL, own.collection.nunique(), unit=UNIT)
        return cannot_tell(nothing, "no policy works")
    found = over_collections(contrast(own, outside), tests=tests)
    groups = (own[own.region.isin(regions)] for regions in (["CO"], outside))
    means = [group.groupby("collection").success.mean() for group in groups]
    return percents(found, *means)


def co_beats_rest(variant: str = NOMINAL, task: str = TASK) -> Judge:
    """Whether compliant, overdamped cells succeed more than all others."""

    def judge(evidence: Evidence, published: Published, tests: int) -> Finding:
        if (own := anew(evidence, variant, task)) is not None:
            return _over_collections(own, REGIONS[1:], tests)
        cells = cells_of(evidence, variant, task)
        co = cells[cells.region == "CO"].success.to_numpy()
        rest = cells[cells.region != "CO"].success.to_numpy()
        if cells.success.max() < WORKS:
            told = percents(Finding(Verdict.CANNOT_TELL, len(cells)), co, rest)
            return cannot_tell(told, "no policy works")
        return percents(greater(co, rest, tests=tests, claimed=published.effect), co, rest)

    return judge


def _against(region: str) -> Judge:
    def judge(evidence: Evidence, published: Published, tests: int) -> Finding:
        if (own := anew(evidence)) is not None:
            return _over_collections(own, [region], tests)
        cells = cells_of(evidence)
        co = cells[cells.region == "CO"].success.to_numpy()
        other = cells[cells.region == region].success.to_numpy()
        return percents(greater(co, other, tests=tests, claimed=published.effect), co, other)

    return judge


def _slope(gain: str, sign: int) -> Judge:
    def judge(evidence: Evidence, published: Published, tests: int) -> Finding:
        if (own := anew(evidence)) is not None:
            return over_collections(slopes(own)[gain == "kd"], sign, tests)
        cells = cells_of(evidence)
        fit = share_slopes(cells.kp, cells.kd, cells.successes, cells.rollouts)
        value, error = getattr(fit, gain), getattr(fit, f"{gain}_error")
        n, claimed = len(cells), published.effect
        return signed(value, error, fit.freedom, sign, n, tests=tests, claimed=claimed)

    return judge


def _pooled_slopes(evidence: Evidence, published: Published, tests: int) -> Finding:
    tables = pd.concat(
        evidence.of_one(study, partial(cells_of, task=task)) for task, study in STUDY_TASKS.items()
    )
    by_gains = tables.groupby(["kp", "kd"], as_index=False)
    cells = by_gains[["successes", "rollouts"]].sum()[by_gains.size()["size"] == len(STUDY_TASKS)]
    fit = share_slopes(cells.kp, cells.kd, cells.successes, cells.rollouts)
    return both_slopes(fit, {"kp": -1, "kd": +1}, len(cells), published)


def _loss_by_stiffness(evidence: Evidence, published: Published, tests: int) -> Finding:
    if (own := anew(evidence, NOMINAL, TASK, LOSS)) is not None:
        groups = [own[own.region.isin(regions)] for regions in (["CO", "CU"], ["SO", "SU"])]
        compliant, stiff = (group.groupby("collection")[LOSS].mean() for group in groups)
        found = over_collections((compliant - stiff).to_numpy(), tests=tests)
        return among(found, "{:.2g} and {:.2g} rad²", compliant, stiff)
    cells = cells_of(evidence, NOMINAL, TASK, LOSS)
    compliant = cells.region.isin(["CO", "CU"])
    loss = cells.validation_mse_rad2.to_numpy()
    found = greater(loss[compliant], loss[~compliant], tests=tests)
    return among(found, "{:.2g} and {:.2g} rad²", loss[compliant], loss[~compliant])


def _loss_and_success(evidence: Evidence, published: Published, tests: int) -> Finding:
    if (own := anew(evidence, NOMINAL, TASK, LOSS)) is not None:
        return of_each(own, lambda cells: spearman(cells[LOSS], cells.success), +1, tests)
    cells = cells_of(evidence, NOMINAL, TASK, LOSS)
    x, y = cells.validation_mse_rad2, cells.success
    return correlated(x, y, +1, tests=tests, claimed=published.effect)


def _replays(evidence: Evidence) -> pd.DataFrame:
    """Replays with each command held as the study holds it, where both ways are there."""
    table = evidence.table(
        "fidelity", ("kp", "kd", "success", "mse_q_rad2", "hold", "decimation"), task=TASK
    )
    if len(table.groupby(["kp", "kd"])) < 4:
        raise AbsentError("fewer than four cells with replays")
    return table[table.hold == "sample"] if (table.hold == "sample").any() else table


def _retargeting_success(evidence: Evidence, published: Published, tests: int) -> Finding:
    table = _replays(evidence)
    fast = table[SIMULATION_RATE_HZ / table.decimation >= published.values["rate_hz"]]
    counts = fast.groupby(["kp", "kd", "decimation"]).success.agg(["sum", "size"])
    found = shares_at_least(counts["sum"], counts["size"], published.values["share"])
    return among(found, "at least {:.0%}", [found.value])


def _retargeting_error(evidence: Evidence, published: Published, tests: int) -> Finding:
    table = _replays(evidence)
    fast = table[SIMULATION_RATE_HZ / table.decimation >= published.values["rate_hz"]]
    errors = fast.groupby(["kp", "kd", "decimation"]).mse_q_rad2.mean()
    found = every_at_most(errors.to_numpy(), published.values["mse_rad2"])
    return among(found, "at most {:.1g} rad²", [found.value])


def _retargeting_degrades(evidence: Evidence, published: Published, tests: int) -> Finding:
    table = _replays(evidence)
    rate = SIMULATION_RATE_HZ / table.decimation
    bound = published.values["rate_hz"]
    slow, fast = table[rate < bound], table[rate == bound]
    if slow.empty or fast.empty:
        raise AbsentError("no replays on either side of 20 Hz")
    before, after = (part.groupby(["kp", "kd"]).success.mean() for part in (fast, slow))
    return percents(paired_greater((before - after).to_numpy(), tests=tests), before, after)


def _end_to_end(evidence: Evidence, published: Published, tests: int) -> Finding:
    policies = _of_every_collection(evidence, OPERATED, OPERATED_TASK)
    ends = [
        policies[gain].isin([policies[gain].min(), policies[gain].max()]) for gain in ("kp", "kd")
    ]
    units = policies[ends[0] & ends[1]].groupby(["kp", "kd", "collection"], as_index=False)
    collections = units.success.mean()
    regions = splits()["cloning"].regions(collections.kp, collections.kd)
    success = {name: collections.success[regions == name].to_numpy() for name in REGIONS}
    if not all(map(len, success.values())):
        raise AbsentError("no four corners with an operator")
    found = every([greater(success["CO"], success[name], tests=tests) for name in REGIONS[1:]])
    form = ", ".join(f"{name} {{:.0%}}" for name in REGIONS)
    return among(replace(found, n=len(collections)), form, *success.values())


def _task(key: str, what: str, task: str) -> Claim:
    statement = f"{what}: compliant, overdamped gains succeed more often than all others."
    judged = {"judge": co_beats_rest(task=task), "tests": len(STUDY_TASKS)}
    own = {"about": STUDY_TASKS[task], "anew": OF_COLLECTIONS.get(task, "")}
    return Claim(key, statement, CELLS, CO_REST + OR_COLLECTIONS, CO_REST_NULL, **judged, **own)


CLAIMS = [
    Claim(
        "retargeting_success",
        "Demonstrations survive retargeting at the corners of the grid.",
        "cell and rate",
        "the share of replays reaches the bound in each",
        judge=_retargeting_success,
        about=GRID,
    ),
    Claim(
        "retargeting_error",
        "Retargeted demonstrations follow the original ones.",
        "cell and rate",
        "the mean error is within the bound in each",
        judge=_retargeting_error,
        about=GRID,
    ),
    Claim(
        "retargeting_degrades",
        "Replays of slower commands than 20 Hz fail more often.",
        "cell",
        "success at 20 Hz less that below, within cells, one-sided sign-flip test",
        "success does not fall",
        judge=_retargeting_degrades,
        about=GRID,
    ),
    _task("co_block_stack", "Block stacking", TASK),
    _task("co_handover", "Bimanual handover", "bimanual_handover"),
    _task("co_unloading", "Dishrack unloading", "dishrack_unloading"),
    _task("co_loading", "Dishrack loading", "dishrack_loading"),
    _task("co_dishwasher", "Dishwasher opening", "dishwasher"),
    _task("co_mug", "Mug hanging", "mug_hanging"),
    Claim(
        "stiffness_hurts",
        "Block stacking: stiffness lowers the odds of success.",
        CELLS,
        "slope of the log odds per doubling of Kp, over-dispersed by cell, one-sided t"
        + OR_COLLECTIONS,
        "the slope is not negative",
        _slope("kp", -1),
        about=GRID,
        anew=ANEW,
    ),
    Claim(
        "damping_helps",
        "Block stacking: damping raises the odds of success.",
        CELLS,
        "slope of the log odds per doubling of Kd, over-dispersed by cell, one-sided t"
        + OR_COLLECTIONS,
        "the slope is not positive",
        _slope("kd", +1),
        about=GRID,
        anew=ANEW,
    ),
    Claim(
        "pooled_slopes",
        "Both slopes hold over six tasks together.",
        "cell (sum over tasks and training seeds)",
        "slopes of the log odds per doubling, over-dispersed by cell, one-sided t, the greater p",
        "a slope is zero, or has the other sign",
        _pooled_slopes,
    ),
    Claim(
        "compliant_once_overdamped",
        "Among overdamped gains, compliant ones succeed more often.",
        CELLS,
        "success of cells in CO against SO, one-sided Mann-Whitney" + OR_COLLECTIONS,
        "success in CO is not greater than in SO",
        _against("SO"),
        about=GRID,
        anew=ANEW,
    ),
    Claim(
        "overdamped_once_compliant",
        "Among compliant gains, overdamped ones succeed more often.",
        CELLS,
        "success of cells in CO against CU, one-sided Mann-Whitney" + OR_COLLECTIONS,
        "success in CO is not greater than in CU",
        _against("CU"),
        about=GRID,
        anew=ANEW,
    ),
    Claim(
        "compliant_loss_higher",
        "Commands for compliant gains are harder to fit.",
        CELLS,
        "validation error of compliant cells against stiff ones, one-sided Mann-Whitney"
        + OR_COLLECTIONS,
        "the error of compliant cells is not greater",
        _loss_by_stiffness,
        about=GRID,
        anew=ANEW,
    ),
    Claim(
        "loss_misleads",
        "Gains with a higher loss succeed more often.",
        CELLS,
        "rank correlation of success with the validation error, one-sided" + OR_COLLECTIONS,
        "the correlation is not positive",
        _loss_and_success,
        about=GRID,
        anew=ANEW,
    ),
    Claim(
        "end_to_end",
        "CO is still best when demonstrations are collected under each gain.",
        "collection of demonstrations at a corner (mean over training seeds)",
        "success of policies at CO against each other corner's, one-sided Mann-Whitney, the "
        "greatest p; demonstrations by a model of an operator, collected anew for each unit",
        "success at CO is not greater than at one of the other corners",
        _end_to_end,
        about="end_to_end",
    ),
]
