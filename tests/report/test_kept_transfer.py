"""Tables of the page on transfer and reinforcement learning are those of the kept data."""

import re

import numpy as np
import pandas as pd
import pytest

from t2l.rl.results import TOLERATED
from t2l.stats.bootstrap import bootstrap_interval, ratio
from t2l.study.decoupling.summary import STEADY, chosen
from t2l.study.passing import passes
from tests.conftest import ROOT

PAGE = (ROOT / "docs/results_transfer.md").read_text(encoding="utf-8")
CORNERS = [(16, 24), (16, 2), (512, 24), (512, 2)]  # as the page has them: CO, CU, SO, SU


def read(name):
    return pd.read_csv(ROOT / f"docs/data/{name}.csv")


def row(words):
    """The cells of the one row that begins so."""
    (cells,) = re.findall(rf"^\| {re.escape(words)}[^|]*\|(.*)\|$", PAGE, flags=re.M)
    return [cell.strip(" *") for cell in cells.split("|")]


def by_corner(table):
    return [table[(table.kp == kp) & (table.kd == kd)] for kp, kd in CORNERS]


def test_policies_with_the_scales_of_the_study():
    table = read("published_scales").query("updates == 1000 and without.isna()")
    for (kp, kd), own in table.groupby(["kp", "kd"]):
        mean = own.mean(numeric_only=True)
        shares = mean[
            ["success_sim_100", "success_sim", "success_real", "stopped_rate", "jitter_rate"]
        ]
        told = [f"{100 * share:.0f} %" for share in shares]
        assert row(f"{kp}, {kd} ") == [*told, f"{mean.trajectory_error:.3f}"]


def test_trials_and_trainings_at_the_corners():
    trials, again = by_corner(read("landscape")), by_corner(read("landscape_again"))
    assert row("trials above 95 % success") == [str(passes(t.success).sum()) for t in trials]
    first = [t.sort_values("number").head(10) for t in trials]
    assert row("of the first ten") == [str(passes(t.success).sum()) for t in first]
    runs = [t.groupby(["configuration", "seed"]).success.max() for t in again]
    assert row("trained again: runs") == [f"{passes(r).sum()} of {len(r)}" for r in runs]
    references = read("landscape_references").query("number < 20")
    for words, name in (("absolute", "absolute"), ("before", "relative_to_target")):
        own = by_corner(references[references.condition == name])
        told = ", ".join(str(passes(trials.success).sum()) for trials in own)
        assert f"{words} {told}" in " ".join(PAGE.split())


@pytest.mark.parametrize(
    ("words", "column"),
    [
        ("success in 100 episodes of the simulator", "success_sim_100"),
        ("robot: rollouts that jitter", "jitter_rate"),
        ("robot: rollouts that are stopped", "stopped_rate"),
        ("success on the robot", "success_real"),
    ],
)
def test_rates(words, column):
    means = read("transfer_rates").groupby("policy_rate_hz")[column].mean()
    assert row(words) == [f"{100 * share:.1f} %" for share in means]


@pytest.mark.parametrize(
    ("words", "name"),
    [("as the study: each", "published"), ("gains known", "known"), ("… with", "multisine")],
)
def test_what_identification_is_off_by(words, name):
    table = read(f"identified_{name}")
    with np.errstate(divide="ignore"):  # what comes out as 0 is off by any factor
        factor = np.maximum(table.ratio, 1 / table.ratio)
    off = factor.groupby(table.parameter, sort=False).median()
    assert row(words) == [f"{factor:.2f}" for factor in off]


@pytest.mark.parametrize(("words", "name"), [("soft arm", "soft"), ("stiff arm", "stiff")])
def test_stiffness(words, name):
    table = chosen(read("decoupling"))
    own = table[table.pairing.str.startswith(name)].sort_values("stiffness_n_m")
    drift, swing = (
        ", ".join(f"{100 * value:.0f}" for value in own[column]) for column in ("drift", "swing")
    )
    force = ", ".join(f"{value:.0f}" for value in own.stiffness_n_m)
    bare, held = f"{own.passive_n_m.median():.0f}", f"{100 * own.success.min():.0f} %"
    assert row(words) == [force, bare, f"{drift} %", f"{swing} %", held]


def test_how_far_stiffness_is_told():
    table = chosen(read("decoupling"))
    soft, stiff = (own for _, own in table.groupby("kp"))
    text = " ".join(PAGE.split())
    assert soft.stiffness_n_m.min() > 10 * stiff.stiffness_n_m.max()
    assert (soft.drift <= STEADY).all()
    assert (stiff.drift <= STEADY).sum() == 1
    near = sorted(stiff.drift)[1:4]
    assert f"by {100 * (near[0] - STEADY):.1f} to {100 * (near[-1] - STEADY):.1f} points" in text
    pair = soft.stiffness_n_m.to_numpy(), stiff.stiffness_n_m.to_numpy()
    lower, upper = bootstrap_interval(ratio, *pair)
    assert f"geometric means is {ratio(*pair):.0f} ({lower:.0f} to {upper:.0f}," in text


def test_no_trial_of_the_search_keeps_the_limits():
    trials = read("transfer_search").query("updates == 1000")
    good = trials[trials.success >= 0.95]
    text = " ".join(PAGE.split())
    assert f"{len(good)} of {len(trials)} trials reach 95 % success" in text
    low, high = 100 * good.torque_rate.min(), 100 * good.torque_rate.max()
    assert f"in {low:.0f} to {high:.0f} % of episodes" in text
    keeps = (trials[list(TOLERATED)] <= pd.Series(TOLERATED)).all(axis=1)
    assert not keeps[good.index].any()
    keeping = trials[keeps]
    assert f"succeed in {100 * keeping.success.max():.0f} % of episodes at most" in text
