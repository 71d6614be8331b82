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
        table = evidence.table("policies", ("kp", "kd", "success_sim_100"), condition=condition)
        best = [rows.success_sim_100.max() for rows in corners(table).values()]
        counts = [round(EPISODES * share) for share in best]
        found = shares_at_least(counts, [EPISODES] * len(counts), published.values["share"])
        return among(found, "{:.0%}, {:.0%}, {:.0%}, {:.0%}", *([share] for share in best))

    return judge


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


def _steps(evidence: Evidence, condition: str, success: float) -> pd.DataFrame:
    """A row a training: kp, kd, steps until it first succeeds so often, or all that it had."""
    columns = ("kp", "kd", "seed", "steps", "success")
    table = evidence.table("training", columns, condition=condition)
    rows = []
    for (kp, kd, seed), part in table.groupby(["kp", "kd", "seed"]):
        reached = part[part.success >= success]
        steps = reached.steps.min() if len(reached) else part.steps.max()
        rows.append((kp, kd, seed, steps))
    return pd.DataFrame(rows, columns=["kp", "kd", "seed", "steps"])


def spread(*groups: np.ndarray) -> np.ndarray:
    """The greatest geometric mean over the least, along the last axis."""
    means = np.stack([np.log(group).mean(axis=-1) for group in groups])
    return np.exp(means.max(axis=0) - means.min(axis=0))


def _efficiency(evidence: Evidence, published: Published, tests: int) -> Finding:
    table = _steps(evidence, TASKS[0], published.values["success"])
    groups = [rows.steps.to_numpy() for rows in corners(table).values()]
    found = within(spread, *groups, high=published.values["factor"])
    return among(found, "factor {:.2f}", [float(spread(*groups))])


def _exists(key: str, what: str, condition: str = "", study: str = "") -> Claim:
    statement = f"{what}: a successful policy exists at all four corners of the gains."
    if not condition:
        return Claim(key, statement)
    rule = "the best policy reaches the share of its 100 episodes at each corner: CO, CU, SO, SU"
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
        "training seed",
        "steps to 95 % success of the slowest corner over the quickest are within a factor of "
        "two, by its bootstrap interval",
        judge=_efficiency,
        about=STUDY,
    ),
]
