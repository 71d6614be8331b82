"""Claims about transfer from simulation to a robot: error, oscillation, policy rate."""

from dataclasses import replace

import numpy as np
import pandas as pd

from t2l.stats.bootstrap import FEWEST, log_ratio, mean
from t2l.stats.slopes import log_slopes
from t2l.stats.verdict import (
    Finding,
    Verdict,
    above_zero,
    correlated,
    greater,
    paired_greater,
    within,
)
from t2l.study import identification
from t2l.study.both_slopes import both_slopes
from t2l.study.claim import Claim, Judge
from t2l.study.evidence import AbsentError, Evidence
from t2l.study.passing import passes
from t2l.study.published.numbers import Published, splits
from t2l.study.words import among, cannot_tell, percents

DECISION = "transfer_decision"
RATED = "transfer_rates"
# as the shipped studies call them, and which of these is about each; the first is the nominal one,
# at 50 Hz
CONDITIONS = {
    "joint_reach": ("Joint-Reach", DECISION),
    "joint_reach_randomised": ("Joint-Reach with domain randomisation", "paper"),
    "end_effector_reach": ("EE-Reach", "paper"),
}
RATES = {
    "joint_reach_100_hz": 100,
    "joint_reach": 50,
    "joint_reach_20_hz": 20,
    "joint_reach_10_hz": 10,
}
NOMINAL = "joint_reach"
POLICY = ("kp", "kd", "seed")  # what names one
CELLS = "cell (mean over rollouts and training seeds)"
NO_LIMITS = "keeps the study's limits"
NOTHING = "nothing jitters, at no rate"
FEASIBLE = 1.0  # bound: of the study's objective, from which on a policy keeps its limits


def working(evidence: Evidence, condition: str) -> pd.DataFrame:
    """Policies that work in their own simulator: what fails there is no failure of transfer.

    Of these the ones that keep the study's limits, which is what the study deploys; all of them
    where none does (`_none_deployable`).
    """
    columns = ("kp", "kd", "success_sim_100", "objective")
    policies = evidence.table("policies", columns, condition=condition)
    policies = policies[passes(policies.success_sim_100)]
    keeping = policies[policies.objective >= FEASIBLE]
    return policies if keeping.empty else keeping


def cells_of(evidence: Evidence, condition: str, *columns: str) -> pd.DataFrame:
    """One row a cell: kp, kd, region, and the mean of each column over what is known of it.

    Of `working` policies.
    """
    table = evidence.table("transfer", ("kp", "kd", *columns), condition=condition)
    policies = working(evidence, condition)
    table = table.merge(policies[[key for key in POLICY if key in policies and key in table]])
    numbers = table[["kp", "kd"]].assign(**{name: table[name].astype(float) for name in columns})
    cells = numbers.groupby(["kp", "kd"], as_index=False).mean().dropna()
    if cells.empty:
        raise AbsentError(f"nothing known of {', '.join(columns)}")
    return cells.assign(region=splits()["transfer"].regions(cells.kp, cells.kd))


def deployable(judge: Judge, *conditions: str) -> Judge:
    """The judge of policies that the study would deploy: told only where there are some."""

    def judged(evidence: Evidence, published: Published, tests: int) -> Finding:
        found = judge(evidence, published, tests)
        policies = [working(evidence, name) for name in conditions]
        if any((each.objective >= FEASIBLE).any() for each in policies):
            return found
        number = sum(map(len, policies))
        return cannot_tell(found, f"of {number} policies none {NO_LIMITS}")

    return judged


def _groups(cells: pd.DataFrame, column: str) -> tuple[np.ndarray, np.ndarray]:
    inside = (cells.region == "SO").to_numpy()
    return cells[column].to_numpy()[inside], cells[column].to_numpy()[~inside]


def _error(condition: str) -> Judge:
    def judge(evidence: Evidence, published: Published, tests: int) -> Finding:
        cells = cells_of(evidence, condition, "trajectory_error")
        so, rest = _groups(cells[cells.trajectory_error > 0], "trajectory_error")
        claimed = np.log(published.values["factor"])
        found = greater(so, rest, tests=tests, claimed=claimed, statistic=log_ratio)
        return among(found, f"{{:.3g}} ({len(so)}) and {{:.3g}} ({len(rest)})", so, rest)

    return judge


def _slopes(condition: str) -> Judge:
    def judge(evidence: Evidence, published: Published, tests: int) -> Finding:
        cells = cells_of(evidence, condition, "trajectory_error")
        cells = cells[cells.trajectory_error > 0]
        fit = log_slopes(cells.kp, cells.kd, cells.trajectory_error)
        return both_slopes(fit, {"kp": +1, "kd": +1}, len(cells), published)

    return judge


def _oscillation(condition: str) -> Judge:
    def judge(evidence: Evidence, published: Published, tests: int) -> Finding:
        columns = ("jitter_failure", "jitter_failure_sim")
        cells = cells_of(evidence, condition, *columns)
        cells["more"] = cells.jitter_failure - cells.jitter_failure_sim
        so, rest = _groups(cells, "more")
        return percents(greater(so, rest, tests=tests), so, rest)

    return judge


def _modes(evidence: Evidence, published: Published, tests: int) -> Finding:
    table = evidence.table("transfer", ("kp", "kd", "jitter_failure", "stopped"), condition=NOMINAL)
    ended = table[table.stopped == ""]
    if ended.empty:
        raise AbsentError("no rollout that lasted long enough")
    of_cell = ended.jitter_failure.astype(float).groupby([ended.kp, ended.kd])
    shaking_cells, settled_cells = (
        int(some.sum()) for some in (of_cell.max() > 0, of_cell.min() < 1)
    )
    if min(shaking_cells, settled_cells) < FEWEST:
        ours = f"rollouts jitter in {shaking_cells} cells and settle in {settled_cells}"
        return Finding(Verdict.CANNOT_TELL, len(of_cell), ours=ours)
    table = evidence.table("transfer", ("kp", "kd", "jitter_rad_s"), condition=NOMINAL)
    known = table[np.isfinite(table.jitter_rad_s.astype(float))]
    limit, factor = published.values["threshold"], published.values["factor"]
    near = known.jitter_rad_s.between(limit / factor, limit * factor)
    shares = near.groupby([known.kp, known.kd]).mean().to_numpy()
    found = within(mean, shares, high=published.values["share"])
    settled = known[known.jitter_rad_s <= limit].jitter_rad_s.median()
    shaking = known[known.jitter_rad_s > limit].jitter_rad_s.median()
    form = "{:.2g} and {:.2g} rad/s, {:.1%} near the threshold"
    return among(found, form, [settled], [shaking], shares)


def _by_rate(evidence: Evidence, names: list[str]) -> pd.DataFrame:
    """Share of rollouts that jitter: a row a cell that all have, a column a rate in Hz."""
    columns = {
        RATES[name]: cells_of(evidence, name, "jitter_failure").set_index(["kp", "kd"])
        for name in names
    }
    shares = {hertz: table.jitter_failure for hertz, table in columns.items()}
    return pd.concat(shares, axis=1).dropna()


def _rate(evidence: Evidence, published: Published, tests: int) -> Finding:
    table = _by_rate(evidence, ["joint_reach_100_hz", "joint_reach_10_hz"])
    if not table.to_numpy().any():
        return Finding(Verdict.CANNOT_TELL, len(table), ours=NOTHING)
    fall = (table[100] - table[10]).to_numpy()
    found = paired_greater(fall, tests=tests, claimed=published.effect)
    return percents(found, table[100], table[10])


def sharpest(at_100: np.ndarray, at_50: np.ndarray, at_20: np.ndarray, at_10: np.ndarray):
    """How much more jitter falls from 50 to 20 Hz than at any other step, along the last axis."""
    means = [np.mean(values, axis=-1) for values in (at_100, at_50, at_20, at_10)]
    others = np.maximum(means[0] - means[1], means[2] - means[3])
    return (means[1] - means[2]) - others


def _sharpest(evidence: Evidence, published: Published, tests: int) -> Finding:
    table = _by_rate(evidence, list(RATES))
    if not table.to_numpy().any():
        return Finding(Verdict.CANNOT_TELL, len(table), ours=NOTHING)
    shares = [table[hertz].to_numpy() for hertz in RATES.values()]
    found = above_zero(sharpest, *shares, paired=True)
    return among(found, "{:.1%}, {:.1%}, {:.1%}, {:.1%} at 100, 50, 20, 10 Hz", *shares)


def _network(evidence: Evidence, published: Published, tests: int) -> Finding:
    cells = cells_of(evidence, NOMINAL, "nn_error", "trajectory_error")
    return correlated(cells.nn_error, cells.trajectory_error, +1, tests=tests)


def _inverse(evidence: Evidence, published: Published, tests: int) -> Finding:
    """S* of the simulators that the deployed policies were trained in."""
    cells = cells_of(evidence, NOMINAL, "trajectory_error")
    both = cells.merge(identification.errors(evidence)[["kp", "kd", "error"]], on=["kp", "kd"])
    return correlated(both.error, both.trajectory_error, -1, tests=tests)


def _registered(evidence: Evidence, published: Published, tests: int) -> Finding:
    """What the study's own rule, registered in its configuration, came to."""
    table = evidence.table("decision", ("what", "cells", "holds"))
    row = table[table.what == "verdict"].iloc[0]
    steps = table[table.holds.isin(["yes", "no"])]
    held = f"{(steps.holds == 'yes').sum()} of {len(steps)} requirements hold"
    found = Finding(Verdict(row.holds), int(row.cells), ours=held)
    try:
        policies = working(evidence, NOMINAL)
    except AbsentError:
        return found
    # the rule is registered, and so decides; that it asks for no limits is told beside it
    limits = f"; no policy {NO_LIMITS}" if (policies.objective < FEASIBLE).all() else ""
    return replace(found, ours=held + limits)


CLAIMS = [
    Claim(
        "transfer_decision",
        "Stiff, overdamped gains transfer worse, and they fail by oscillation.",
        CELLS,
        "the rule of `transfer_decision` in the configuration: ln E rises with Kp and with Kd, and "
        "jitter beyond simulation is greater in SO, each at α",
        "one of the three does not hold",
        _registered,
        about=DECISION,
    ),
    *(
        Claim(
            f"transfer_{name}",
            f"{title}: the error of transfer is greatest at stiff, overdamped gains.",
            CELLS,
            "E of cells in SO against all others, one-sided Mann-Whitney",
            "E in SO is not greater than outside",
            deployable(_error(name), name),
            tests=len(CONDITIONS),
            about=study,
        )
        for name, (title, study) in CONDITIONS.items()
    ),
    *(
        Claim(
            f"slopes_{name}",
            f"{title}: the error of transfer grows with stiffness and with damping.",
            CELLS,
            "slopes of ln E per doubling of Kp and of Kd, one-sided t; both hold",
            "one of the slopes is not positive",
            deployable(_slopes(name), name),
            about=study,
        )
        for name, (title, study) in CONDITIONS.items()
    ),
    Claim(
        "oscillation",
        "Stiff, overdamped gains fail by oscillation on the robot that their simulator lacks.",
        CELLS,
        "share of rollouts that jitter to their end on the robot less that in simulation, SO "
        "against all others, one-sided Mann-Whitney; what was stopped does not jitter",
        "the difference in SO is not greater",
        deployable(_oscillation(NOMINAL), NOMINAL),
        about=DECISION,
    ),
    Claim(
        "oscillation_randomised",
        "They do so in spite of domain randomisation.",
        CELLS,
        "as above, of policies trained with randomisation",
        "the difference in SO is not greater",
        deployable(_oscillation("joint_reach_randomised"), "joint_reach_randomised"),
        about=CONDITIONS["joint_reach_randomised"][1],
    ),
    Claim(
        "oscillation_modes",
        "The threshold separates rollouts that settle from those that jitter.",
        "cell",
        "at most 5 % of rollouts lie within a factor of two of it, by the bootstrap interval; told "
        "only where rollouts settle in three cells at least, and jitter in three",
        judge=_modes,
        about=DECISION,
    ),
    Claim(
        "policy_rate",
        "Slower policies jitter less often.",
        CELLS,
        "share at 100 Hz less that at 10 Hz, within cells, one-sided sign-flip test",
        "jitter does not fall",
        deployable(_rate, "joint_reach_100_hz", "joint_reach_10_hz"),
        about=RATED,
    ),
    Claim(
        "policy_rate_sharpest",
        "Jitter falls most between 50 and 20 Hz.",
        CELLS,
        "that fall less the greatest other one is above 0, by its bootstrap interval",
        judge=deployable(_sharpest, *RATES),
        about=RATED,
    ),
    Claim(
        "network_error",
        "The policy's outputs on robot and simulator differ where the motions differ.",
        CELLS,
        "rank correlation of the error of outputs with E, one-sided",
        "the correlation is not positive",
        deployable(_network, NOMINAL),
        about=DECISION,
    ),
    Claim(
        "inverse_relation",
        "Gains that are identified well transfer badly.",
        CELLS,
        "rank correlation of S* with E, one-sided",
        "the correlation is not negative",
        deployable(_inverse, NOMINAL),
        about=DECISION,
    ),
]
