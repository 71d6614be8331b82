"""The rule comes out each way on tables that are planted so, and on nothing else."""

import numpy as np
import pandas as pd
import pytest

from t2l.gains import Cell
from t2l.stats.verdict import Verdict
from t2l.study.transfer.decision import decide, printable_decision
from t2l.study.transfer.rule import Rule

CELLS = [Cell(kp, kd) for kd in (2, 8, 16, 24) for kp in (16, 128, 512)]
RULE = Rule("joint_reach", 0.05, 128, 8, cells=11, seeds=3, success=0.9)


def planted(slope_kp=0.3, slope_kd=0.3, jitter_so=0.8, jitter_rest=0.1, in_simulation=0.0, seed=0):
    """Rollouts and policies of the cells above with effects of given sizes."""
    draw = np.random.default_rng(seed)
    rollouts, policies = [], []
    for cell in CELLS:
        inside, own = cell.kp >= 128 and cell.kd >= 8, draw.normal(0, 0.2)
        for number in (1, 2, 3):
            log = slope_kp * np.log2(cell.kp) + slope_kd * np.log2(cell.kd) + own
            log += draw.normal(0, 0.2)
            rate = (jitter_so if inside else jitter_rest) + draw.uniform(-0.05, 0.05)
            policies.append((cell.kp, cell.kd, number, 1.0, np.exp(log)))
            for i in range(10):
                error = np.exp(log + draw.normal(0, 0.1)) / 1e3
                shakes = (i < 10 * rate, i < 10 * in_simulation)
                rollouts.append((cell.kp, cell.kd, number, error, *shakes, ""))
    columns = ["kp", "kd", "seed", "trajectory_error", "jitter_failure", "jitter_failure_sim"]
    return (
        pd.DataFrame(rollouts, columns=[*columns, "stopped"]),
        pd.DataFrame(policies, columns=["kp", "kd", "seed", "success_sim_100", "feedback_gain"]),
    )


def verdict(table):
    assert table.what.iloc[-1] == "verdict"
    return table.holds.iloc[-1]


def test_a_planted_trend_is_found():
    table = decide(*planted(), RULE)
    assert verdict(table) == Verdict.REPRODUCED
    assert table.holds[:3].tolist() == ["yes"] * 3
    assert table.found[0] == pytest.approx(0.3, abs=0.1)
    assert (table.cells[0], table.policies[0]) == (12, 36)
    # made to follow E
    assert table.found[4] > 0.9
    assert "reproduced" in printable_decision(table).to_string()


@pytest.mark.parametrize(
    "absent",
    [
        {"slope_kp": 0.0},
        {"slope_kd": 0.0},
        {"slope_kp": -0.3},
        {"jitter_so": 0.1},
        # shakes by itself
        {"in_simulation": 0.8, "jitter_rest": 0.8},
    ],
    ids=str,
)
def test_what_is_not_there_is_not_found(absent):
    assert verdict(decide(*planted(**absent), RULE)) == Verdict.NOT_REPRODUCED


def test_chance_is_seldom_taken_for_the_trend():
    nothing = {"slope_kp": 0.0, "slope_kd": 0.0, "jitter_so": 0.1}
    found = [verdict(decide(*planted(**nothing, seed=seed), RULE)) for seed in range(10)]
    assert found.count(Verdict.REPRODUCED) == 0


def test_policies_that_fail_in_their_own_simulator_are_left_out():
    rollouts, policies = planted()
    one = (policies.kp == 16) & (policies.kd == 2)
    policies.loc[one & (policies.seed == 1), "success_sim_100"] = 0.5
    table = decide(rollouts, policies, RULE)
    assert (table.cells[0], table.policies[0], verdict(table)) == (12, 35, Verdict.REPRODUCED)
    policies.loc[one, "success_sim_100"] = 0.5
    assert decide(rollouts, policies, RULE).cells[0] == 11
    policies.loc[policies.kd == 2, "success_sim_100"] = 0.5
    assert verdict(decide(rollouts, policies, RULE)) == Verdict.CANNOT_TELL
    policies["success_sim_100"] = 0.0
    assert verdict(decide(rollouts, policies, RULE)) == Verdict.CANNOT_TELL


def test_the_best_separation_has_the_least_p():
    # six cells all above six others
    assert decide(*planted(), RULE).p[2] == pytest.approx(1 / 924)
