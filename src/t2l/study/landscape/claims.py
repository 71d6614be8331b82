"""Claims about reinforcement learning: existence, search, sample efficiency."""

from dataclasses import replace

import numpy as np
import pandas as pd

from t2l.gains import Cell
from t2l.stats.verdict import (
    ALPHA,
    Finding,
    Verdict,
    differ,
    every,
    no_common_winner,
    shares_at_least,
    within,
)
from t2l.study.claim import Claim, Judge
from t2l.study.evidence import AbsentError, Evidence
from t2l.study.landscape.existence import COLUMNS, at_corners, existence_table
from t2l.study.passing import passes
from t2l.study.published.numbers import REGIONS, Published, splits
from t2l.study.words import among, cannot_tell

EPISODES = 100  # that judge a policy, as in the study
EPISODES_AGAIN = 50  # that judge one while it trains: `t2l.rl.learn.PROGRESS_EPISODES`
LATE = 0.9  # statistics: quantile over action scales, so that few slow ones are seen too
TASKS = ("joint_reach", "end_effector_reach")
STUDY, LEARNED = "landscape", "existence"
CELL = ("kp", "kd")
UNIT = (*CELL, "configuration")
RUN = (*UNIT, "seed")


def corners(table: pd.DataFrame) -> dict[str, pd.DataFrame]:
    """Rows of the four extreme cells, by region.

    Raises:
        AbsentError: one of them is not there.
    """
    found = {}
    for kp in (table.kp.min(), table.kp.max()):
        for kd in (table.kd.min(), table.kd.max()):
            rows = table[(table.kp == kp) & (table.kd == kd)]
            found[str(splits()["transfer"].regions([kp], [kd])[0])] = rows
    if set(found) != set(REGIONS) or any(rows.empty for rows in found.values()):
        raise AbsentError("not the four corners of a grid")
    return {region: found[region] for region in REGIONS}


def _existence(condition: str) -> Judge:
    def judge(evidence: Evidence, published: Published, tests: int) -> Finding:
        return _reached(*_anew(evidence, condition), published)

    return judge


def _found(task: str) -> Judge:
    """Of the policies that were trained for a task at the corners, all of them together."""

    def judge(evidence: Evidence, published: Published, tests: int) -> Finding:
        columns = [name for name in COLUMNS if name != "region"]
        table = evidence.table("learned", columns)
        own = table[table.task == task]
        cells = {Cell(*gains) for gains in zip(own.kp, own.kd, strict=True)}
        known = existence_table(at_corners(own, {task: cells}))
        if list(known.region) != list(REGIONS):
            raise AbsentError(f"{task}: not the four corners of a grid")
        found = _reached(list(known.successes), list(known.episodes), published)
        if found.verdict is Verdict.REPRODUCED:
            return found
        return cannot_tell(found, "a training that finds no policy shows no absence")

    return judge


def _reached(won: list[int], episodes: list[int], published: Published) -> Finding:
    """Whether the share is reached at each corner in `REGIONS`."""
    found = shares_at_least(won, episodes, published.values["share"])
    form = ", ".join(f"{{:.1%}} of {n}" for n in episodes)
    return among(found, form, *([w / n] for w, n in zip(won, episodes, strict=True)))


def _anew(evidence: Evidence, condition: str) -> tuple[list[int], list[int]]:
    """Successes and episodes at each corner in `REGIONS`, of policies that chose nothing.

    Of action scales that were trained again from several seeds, those count that did best from
    the first half of the seeds, and their policies from the other seeds are judged. Of policies
    that were trained anew with what a search chose, all are.

    Raises:
        AbsentError: there are neither; trials alone are ranked by the episodes that would judge.
    """
    try:
        table = evidence.table("again", (*RUN, "update", "success"), condition=condition)
        parts = [_chosen_by_others(rows) for rows in corners(table).values()]
        each = EPISODES_AGAIN
    except AbsentError:
        columns = ("kp", "kd", "success_sim_100")
        table = evidence.table("policies", columns, condition=condition)
        known = corners(table.dropna(subset="success_sim_100"))
        parts = [rows.success_sim_100.to_numpy() for rows in known.values()]
        each = EPISODES
    won = [int(np.round(each * shares).sum()) for shares in parts]
    return won, [each * len(shares) for shares in parts]


def _chosen_by_others(runs: pd.DataFrame) -> np.ndarray:
    """Success after training from the later seeds, of what did best from the earlier ones."""
    last = runs[runs["update"] == runs["update"].max()]
    seeds = sorted(last.seed.unique())
    half = len(seeds) // 2
    if not half:
        raise AbsentError("nothing was trained from two seeds")
    chooses = last.seed.isin(seeds[:half])
    # of equals the first, which no later look has picked
    best = last[chooses].groupby("configuration").success.mean().idxmax()
    return last[~chooses & (last.configuration == best)].success.to_numpy()


def _counts(evidence: Evidence, condition: str, share: float) -> tuple[list[int], list[int]]:
    """Trials that pass a success rate at each corner in `REGIONS`, and how many were completed."""
    table = evidence.table("trials", ("kp", "kd", "state", "success"), condition=condition)
    done = table[table.state == "complete"]
    rows = corners(done).values()
    return [int(passes(part.success, share).sum()) for part in rows], [len(part) for part in rows]


def _landscape(evidence: Evidence, published: Published, tests: int) -> Finding:
    won, trials = _counts(evidence, TASKS[0], published.values["share"])
    texts = [f"{some} of {all_}" for some, all_ in zip(won, trials, strict=True)]
    return among(differ(won, trials), ", ".join(texts))


def _no_easier(evidence: Evidence, published: Published, tests: int) -> Finding:
    winners, run = [], 0
    for task in TASKS:
        try:
            won, trials = _counts(evidence, task, published.values["share"])
        except AbsentError:
            continue
        run += 1
        verdict = differ(won, trials).verdict
        if verdict is Verdict.REPRODUCED:
            winners.append(REGIONS[int(np.argmax(np.divide(won, trials)))])
        elif verdict is Verdict.NOT_REPRODUCED:
            winners.append("none")
    if not run:
        raise AbsentError("no trials of any task")
    found = no_common_winner(winners, len(REGIONS))
    return among(found, f"easiest: {', '.join(winners) or 'not known'}")


def spread(*groups: np.ndarray) -> np.ndarray:
    """The greatest geometric mean over the least, along the last axis."""
    means = np.stack([np.log(group).mean(axis=-1) for group in groups])
    return np.exp(means.max(axis=0) - means.min(axis=0))


def late_spread(*groups: np.ndarray) -> np.ndarray:
    """The same of the `LATE` quantile in place of the mean."""
    late = np.stack([np.quantile(group, LATE, axis=-1) for group in groups])
    return late.max(axis=0) / late.min(axis=0)


def _comparable(units: pd.DataFrame, published: Published, of: str = "") -> Finding:
    """Whether no corner has more than a factor times another: geometric means of `units.value`.

    Args:
        of: the unit of these, for a person.
    """
    groups = [rows.value.to_numpy() for rows in corners(units).values()]
    found = within(spread, *groups, high=published.values["factor"])
    means = [[np.exp(np.log(group).mean())] for group in groups]
    form = ", ".join(f"{region} {{:.3g}}" for region in REGIONS)
    return among(found, f"{form}{of}: factor {{:.2f}}", *means, [float(spread(*groups))])


def _trainings(evidence: Evidence) -> pd.DataFrame:
    """Rows of `RUN`, steps and success, of what was trained again; else of what was chosen."""
    columns = ("steps", "success")
    try:
        return evidence.table("again", (*RUN, *columns), condition=TASKS[0])
    except AbsentError:
        table = evidence.table("training", (*CELL, "seed", *columns), condition=TASKS[0])
        # there each seed is a unit
        return table.assign(configuration=table.seed)


def _efficiency(evidence: Evidence, published: Published, tests: int) -> Finding:
    rows = []
    for run, part in _trainings(evidence).groupby([*RUN]):
        reached = part[part.success >= published.values["success"]]
        steps = reached.steps.min() if len(reached) else part.steps.max()
        rows.append((*run, np.log(steps)))
    runs = pd.DataFrame(rows, columns=[*RUN, "log_steps"])
    units = runs.groupby([*UNIT], as_index=False).log_steps.mean()
    units["value"] = np.exp(units.log_steps) / 1e6
    middle = _comparable(units, published, " million steps")
    groups = [rows.value.to_numpy() for rows in corners(units).values()]
    late = within(late_spread, *groups, high=published.values["factor"])
    quantiles = [[np.quantile(group, LATE)] for group in groups]
    form = ", ".join(f"{region} {{:.3g}}" for region in REGIONS)
    told = among(late, f"{form}: factor {{:.2f}}", *quantiles, [late.value])
    found = every([middle, late])
    return replace(found, ours=f"{middle.ours}; one in ten takes longer than {told.ours}")


def _stability(evidence: Evidence, published: Published, tests: int) -> Finding:
    table = evidence.table("again", (*RUN, "update", "reward"), condition=TASKS[0])
    # between seeds, at each evaluation; then over the course of training
    variances = table.groupby([*UNIT, "update"]).reward.var()
    means = variances.groupby([*UNIT]).mean().dropna()
    units = np.sqrt(means).rename("value").reset_index()
    if units.empty:
        raise AbsentError("nothing was trained from two seeds")
    return _comparable(units, published)


_ANEW = (
    "policies trained anew, which chose nothing, reach the share at each corner (CO, CU, SO, SU): "
    "of action scales that were trained again, those that did best from the first half of the "
    "seeds, judged from the others"
)
_FOUND = (
    "the fresh episodes of all policies of a corner together reach the share at each corner (CO, "
    "CU, SO, SU), with action scales that were given; if not, it cannot be told"
)


def _exists(key: str, what: str, **judged: object) -> Claim:
    statement = f"{what}: a successful policy exists at all four corners of the gains."
    return Claim(key, statement, **({"unit": "corner"} if judged else {}), **judged)


def _exists_by_training(key: str, what: str, task: str) -> Claim:
    return _exists(key, what, rule=_FOUND, judge=_found(task), about=LEARNED)


CLAIMS = [
    _exists(
        "existence_joint_reach",
        "FR3 Joint-Reach",
        rule=_ANEW,
        judge=_existence(TASKS[0]),
        about=STUDY,
    ),
    _exists_by_training(
        "existence_end_effector_reach", "FR3 EE-Reach", "end_effector_reach_by_distance"
    ),
    _exists_by_training("existence_lift", "FR3 Lift-Cube", "lift_cube"),
    _exists_by_training("existence_drawer", "FR3 Open-Drawer", "open_drawer"),
    _exists_by_training("existence_g1", "G1 Track-Velocity", "track_velocity"),
    # by IsaacLab's goals, as the study says nothing else
    _exists_by_training("existence_allegro", "Allegro in-hand cube", "in_hand_cube_isaaclab"),
    _exists_by_training(
        "existence_nonprehensile", "FR3 non-prehensile reorientation", "reorient_cube"
    ),
    Claim(
        "landscape",
        "How many action scales succeed depends on the gains.",
        "trial (the sampler's trials depend on each other)",
        f"χ² test of homogeneity over the four corners, at α = {ALPHA:g}",
        "all corners share one rate",
        _landscape,
        about=STUDY,
    ),
    Claim(
        "no_easier_regime",
        "No region of gains is easier to tune in every task.",
        "task",
        "the corner with most successes, where corners differ, is not the same in all tasks",
        "tasks draw their easiest corner at random",
        _no_easier,
        about=STUDY,
    ),
    Claim(
        "sample_efficiency",
        "Training takes about as long at all corners.",
        "configuration (mean over training seeds)",
        "every action scale that passed is trained again; steps to 95 % success, or all that a run "
        "had, geometric mean over seeds: of the geometric mean over configurations, and of their "
        "90 % quantile, the slowest corner over the quickest is within a factor of two, by the "
        "bootstrap interval. Where none was trained again: over the training seeds of the one that "
        "was chosen",
        judge=_efficiency,
        about=STUDY,
    ),
    Claim(
        "training_stability",
        "Training is about as stable at all corners.",
        "configuration (over training seeds)",
        "every action scale that passed is trained again; standard deviation of the reward between "
        "seeds, root mean square over training, geometric mean over configurations: the greatest "
        "corner over the least is within a factor of two, by the bootstrap interval",
        judge=_stability,
        about=STUDY,
    ),
]
