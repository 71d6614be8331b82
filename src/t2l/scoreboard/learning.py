"""Claims about reinforcement learning: existence, search, sample efficiency."""

import numpy as np
import pandas as pd

from t2l.published.numbers import Published, splits
from t2l.scoreboard.claim import Claim, Judge
from t2l.scoreboard.evidence import AbsentError, Evidence
from t2l.scoreboard.words import among
from t2l.stats.verdict import (
    ALPHA,
    Finding,
    Verdict,
    differ,
    no_common_winner,
    shares_at_least,
    within,
)

EPISODES = 100  # that judge a trial, as in the study
TASKS = ("joint_reach", "end_effector_reach")
ORDER = ("CO", "CU", "SO", "SU")
STUDY = "landscape"
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
    if set(found) != set(ORDER) or any(rows.empty for rows in found.values()):
        raise AbsentError("not the four corners of a grid")
    return {region: found[region] for region in ORDER}


def _existence(condition: str) -> Judge:
    def judge(evidence: Evidence, published: Published, tests: int) -> Finding:
        best = np.max(_best_of_each(evidence, condition), axis=0)
        counts = [round(EPISODES * share) for share in best]
        found = shares_at_least(counts, [EPISODES] * len(counts), published.values["share"])
        return among(found, "{:.0%}, {:.0%}, {:.0%}, {:.0%}", *([share] for share in best))

    return judge


def _best_of_each(evidence: Evidence, condition: str) -> list[list[float]]:
    """The best at each corner, of policies that were trained again and of trials: each is one.

    Raises:
        AbsentError: there are neither.
    """
    found: list[list[float]] = []
    for kind, success in (("policies", "success_sim_100"), ("trials", "success")):
        try:
            table = evidence.table(kind, ("kp", "kd", success), condition=condition)
            known = corners(table.dropna(subset=success))
        except AbsentError as error:
            absent = error
            continue
        found.append([rows[success].max() for rows in known.values()])
    if not found:
        raise absent
    return found


def _counts(evidence: Evidence, condition: str, share: float) -> tuple[list[int], list[int]]:
    """Trials above a success rate at each corner in `ORDER`, and how many were completed."""
    table = evidence.table("trials", ("kp", "kd", "state", "success"), condition=condition)
    done = table[table.state == "complete"]
    rows = corners(done).values()
    return [int((part.success > share).sum()) for part in rows], [len(part) for part in rows]


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
            winners.append(ORDER[int(np.argmax(np.divide(won, trials)))])
        elif verdict is Verdict.NOT_REPRODUCED:
            winners.append("none")
    if not run:
        raise AbsentError("no trials of any task")
    found = no_common_winner(winners, len(ORDER))
    return among(found, f"easiest: {', '.join(winners) or 'not known'}")


def spread(*groups: np.ndarray) -> np.ndarray:
    """The greatest geometric mean over the least, along the last axis."""
    means = np.stack([np.log(group).mean(axis=-1) for group in groups])
    return np.exp(means.max(axis=0) - means.min(axis=0))


def _comparable(units: pd.DataFrame, published: Published, of: str = "") -> Finding:
    """Whether no corner has more than a factor times another: geometric means of `units.value`.

    Args:
        of: the unit of these, for a person.
    """
    groups = [rows.value.to_numpy() for rows in corners(units).values()]
    found = within(spread, *groups, high=published.values["factor"])
    means = [[np.exp(np.log(group).mean())] for group in groups]
    form = ", ".join(f"{region} {{:.3g}}" for region in ORDER)
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
    return _comparable(units, published, " million steps")


def _stability(evidence: Evidence, published: Published, tests: int) -> Finding:
    table = evidence.table("again", (*RUN, "update", "reward"), condition=TASKS[0])
    # between seeds, at each evaluation; then over the course of training
    variances = table.groupby([*UNIT, "update"]).reward.var()
    means = variances.groupby([*UNIT]).mean().dropna()
    units = np.sqrt(means).rename("value").reset_index()
    if units.empty:
        raise AbsentError("nothing was trained from two seeds")
    return _comparable(units, published)


def _exists(key: str, what: str, condition: str = "", study: str = "") -> Claim:
    statement = f"{what}: a successful policy exists at all four corners of the gains."
    if not condition:
        return Claim(key, statement)
    rule = (
        "the best policy, of a trial or trained with what trials chose, reaches the share of its "
        "100 episodes at each corner: CO, CU, SO, SU"
    )
    return Claim(key, statement, "corner", rule, judge=_existence(condition), about=study)


CLAIMS = [
    _exists("existence_joint_reach", "FR3 Joint-Reach", TASKS[0], STUDY),
    _exists("existence_end_effector_reach", "FR3 EE-Reach", TASKS[1], "paper"),
    _exists("existence_lift", "FR3 Lift-Cube"),
    _exists("existence_drawer", "FR3 Open-Drawer"),
    _exists("existence_g1", "G1 Track-Velocity"),
    _exists("existence_allegro", "Allegro in-hand cube"),
    _exists("existence_nonprehensile", "FR3 non-prehensile reorientation"),
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
        "had, geometric mean over seeds, then over configurations: the slowest corner over the "
        "quickest is within a factor of two, by the bootstrap interval. Where none was trained "
        "again: over the training seeds of the one that was chosen",
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
