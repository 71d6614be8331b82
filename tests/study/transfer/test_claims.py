"""Planted tables come out each way: a trend is found, so is its absence, few cells cannot tell."""

import numpy as np
import pandas as pd
import pytest

from t2l.study.evidence import Evidence
from tests.study.judged import CLAIMS, NO, NOT_RUN, OPEN, YES, verdict
from tests.study.planted import TRANSFER, deployed, evidence, frame, read, transfer

FIVE = [(16, 2), (16, 24), (128, 8), (512, 2), (512, 24)]


@pytest.mark.parametrize("key", ["transfer_joint_reach", "slopes_joint_reach"])
def test_the_error_of_transfer(key):
    def table(**planted):
        return deployed("joint_reach", **planted)

    assert verdict(key, **table(slope=0.5)) is YES
    assert verdict(key, **table()) is NO
    assert verdict(key, **table(slope=-0.5)) is NO
    # more rollouts of five cells, of which one is in G^SO by the paper's count, decide nothing
    few = [cell for cell in FIVE if cell != (128, 8)]
    assert verdict(key, **table(slope=0.5, cells=few, rollouts=50)) is OPEN


def test_the_threshold_of_jitter_separates_what_settles_from_what_shakes():
    def modes(*speeds, cells=TRANSFER):
        """Rollouts of each cell, of which each jitters by a speed, rad/s, or was stopped (NaN)."""
        tables = [
            transfer(cells).assign(
                jitter_rad_s=speed, jitter_failure=speed > 0.04, stopped="" if speed else "too fast"
            )
            for speed in np.nan_to_num(speeds)
        ]
        table = pd.concat(tables, ignore_index=True)
        return table.assign(jitter_rad_s=table.jitter_rad_s.replace(0, np.nan))

    def judged(*tables):
        path = "sim_to_real__joint_reach__rollouts"
        return verdict("oscillation_modes", **{path: pd.concat(tables, ignore_index=True)})

    assert judged(modes(0.001, 0.002, 0.7)) is YES
    assert judged(modes(0.001, 0.05, 0.7)) is NO
    # what was stopped is neither
    assert judged(modes(0.001, 0.7, np.nan)) is YES
    assert judged(modes(np.nan)) is NOT_RUN
    # a threshold separates nothing where there is but one mode, or where two cells have the other
    assert judged(modes(0.001)) is OPEN
    assert judged(modes(0.7)) is OPEN
    assert judged(modes(0.001), modes(0.7, cells=TRANSFER[:2])) is OPEN
    assert judged(modes(0.001), modes(0.7, cells=TRANSFER[:3])) is YES


def test_oscillation_and_policy_rate():
    def shakes(kp, kd, region):
        return 0.9 if region == "SO" else 0.1

    assert verdict("oscillation", **deployed("joint_reach", jitter=shakes)) is YES
    assert verdict("oscillation", **deployed("joint_reach")) is NO
    # what shakes in its own simulator too is no gap
    both = deployed("joint_reach", jitter=shakes)
    table = both["sim_to_real__joint_reach__rollouts"]
    table["jitter_failure_sim"] = table.jitter_failure
    assert verdict("oscillation", **both) is NO
    fast, slow = (deployed(f"joint_reach_{r}_hz", jitter=lambda *_, s=s: s)
                  for r, s in ((100, 0.5), (10, 0.1)))  # fmt: skip
    assert verdict("policy_rate", **fast, **slow) is YES
    fast = deployed("joint_reach_100_hz", jitter=lambda *_: 0.1)
    assert verdict("policy_rate", **fast, **slow) is NO
    assert verdict("policy_rate", **slow) is NOT_RUN


def test_what_fails_in_its_own_simulator_is_no_failure_of_transfer():
    table = transfer(slope=0.5)
    policies = frame(TRANSFER, "transfer", success_sim_100=1.0, objective=2.0)
    tables = {"sim_to_real__joint_reach__rollouts": table}
    assert verdict("transfer_joint_reach", **tables) is NOT_RUN
    working = {"sim_to_real__joint_reach__cells": policies}
    assert verdict("transfer_joint_reach", **tables, **working) is YES
    # the study's trials pass above 95 %
    for share in (0.95, 0.5):
        policies.loc[policies.kp > 100, "success_sim_100"] = share
        assert verdict("transfer_joint_reach", **tables, **working) is OPEN


@pytest.mark.parametrize(
    "key", ["transfer_joint_reach", "slopes_joint_reach", "oscillation", "network_error"]
)
def test_policies_that_the_study_would_not_deploy_tell_nothing_of_transfer(key):
    def shakes(kp, kd, region):
        return 0.9 if region == "SO" else 0.1

    kept, broken = (
        deployed("joint_reach", slope=0.5, jitter=shakes, objective=value) for value in (1.9, 0.3)
    )
    assert verdict(key, **kept) is YES
    assert verdict(key, **broken) is OPEN
    found = CLAIMS[key].finding(evidence(**broken))
    assert found.ours.endswith("; of 12 policies none keeps the study's limits")
    # where some keep them, those count
    cells = broken["sim_to_real__joint_reach__cells"]
    some = cells.assign(objective=np.where(cells.kp < 500, 1.9, 0.3))
    found = CLAIMS[key].finding(evidence(**broken | {"sim_to_real__joint_reach__cells": some}))
    assert found.n == 8


def test_the_registered_rule_of_transfer():
    def decided(verdict, *holds):
        rows = [(f"step {i}", 12, held) for i, held in enumerate(holds)]
        columns = ["what", "cells", "holds"]
        table = pd.DataFrame([*rows, ("verdict", 12, verdict)], columns=columns)
        return {"tables__transfer_decision_joint_reach": table}

    assert verdict("transfer_decision", **decided("reproduced", "yes", "yes", "yes")) is YES
    assert verdict("transfer_decision", **decided("not reproduced", "yes", "no", "no")) is NO
    assert verdict("transfer_decision", **decided("cannot be told", "yes", "yes", "")) is OPEN


def _rates(shares):
    names = ["joint_reach_100_hz", "joint_reach", "joint_reach_20_hz", "joint_reach_10_hz"]
    return {
        path: table
        for name, share in zip(names, shares, strict=True)
        for path, table in deployed(name, jitter=lambda *_, s=share: s).items()
    }


def test_where_jitter_falls_most():
    assert verdict("policy_rate_sharpest", **_rates([0.22, 0.20, 0.07, 0.05])) is YES
    assert verdict("policy_rate_sharpest", **_rates([0.95, 0.03, 0.31, 0.37])) is NO
    # the same share at each rate, and none at all, which leaves nothing that could fall
    assert verdict("policy_rate_sharpest", **_rates([0.2, 0.2, 0.2, 0.2])) is NO
    assert verdict("policy_rate_sharpest", **_rates([0.0, 0.0, 0.0, 0.0])) is OPEN
    assert verdict("policy_rate", **_rates([0.0, 0.0, 0.0, 0.0])) is OPEN


def test_errors_of_outputs_go_with_errors_of_motion():
    tables = deployed("joint_reach", slope=0.3)
    assert verdict("network_error", **tables) is YES
    table = tables["sim_to_real__joint_reach__rollouts"]
    table["nn_error"] = -table.nn_error
    assert verdict("network_error", **tables) is NO


def test_identified_well_and_transferred_badly():
    worse, better = deployed("joint_reach", slope=0.5), deployed("joint_reach", slope=-0.5)
    identified = {
        "sim_to_real__identification": frame(
            TRANSFER, "transfer", s_star=lambda kp, kd, region: 1 / (kp * kd)
        )
    }
    assert verdict("inverse_relation", **identified, **worse) is YES
    assert verdict("inverse_relation", **identified, **better) is NO
    # simulators of another study are not those that the policies learned in
    other = {
        "sim_to_real__identification": frame(
            TRANSFER, "transfer", s_star=lambda kp, kd, region: kp * kd
        )
    }
    both = Evidence([*read("identified", other), *read("deployed", identified | worse)])
    assert CLAIMS["inverse_relation"].finding(both).verdict is YES
    apart = Evidence([*read("identified", other), *read("deployed", worse)])
    assert CLAIMS["inverse_relation"].finding(apart).verdict is NOT_RUN
