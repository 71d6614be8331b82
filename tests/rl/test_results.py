import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from t2l.environment.limits import AT_REST_RAD, LIMITS, NAMES, Limits, violations
from t2l.rl.results import TOLERATED, Evaluation
from t2l.robots import make_robot

ROBOT = make_robot("fr3")

share = st.floats(0, 1)


@given(share, st.fixed_dictionaries(dict.fromkeys(NAMES, share)))
def test_whoever_keeps_the_limits_beats_whoever_does_not(success, rates):
    value = Evaluation(success, rates).objective
    tolerated = all(rates[name] <= TOLERATED[name] for name in LIMITS)
    assert (1 <= value <= 2) if tolerated else (0 <= value <= 1)


@given(share, st.fixed_dictionaries(dict.fromkeys(NAMES, share)), st.sampled_from(NAMES), share)
def test_more_violations_are_never_better(success, rates, name, more):
    worse = rates | {name: max(rates[name], more)}
    assert Evaluation(success, worse).objective <= Evaluation(success, rates).objective + 1e-12


@given(share, share, st.fixed_dictionaries(dict.fromkeys(NAMES, share)), st.floats(0.01, 1))
def test_no_kept_limit_makes_up_for_a_task_unsolved(one, other, rates, solved_at):
    idle = Evaluation(one, dict.fromkeys(NAMES, 0.0)).value(solved_at)
    solved = Evaluation(other, rates)
    if one < solved_at <= other:
        assert idle < solved.value(solved_at)
    if other >= solved_at:
        # of what solves the task, the study's order
        assert solved.value(solved_at) == 1 + solved.objective
    assert solved.value() == solved.objective


def test_the_objective_has_the_study_s_four_limits_and_no_other():
    """Jitter is told, and is no success; it is no constraint of the study's (its App. G)."""
    assert set(TOLERATED) == {"position", "velocity", "torque", "torque_rate"}
    shaking = Evaluation(0.7, dict.fromkeys(LIMITS, 0.0) | {"jitter": 0.3})
    assert shaking.feasible
    assert shaking.objective == pytest.approx(1.7)
    # nor does it take anything from a policy that breaks a limit
    fast = Evaluation(0.7, dict.fromkeys(LIMITS, 0.0) | {"velocity": 0.5, "jitter": 0.3})
    assert fast.objective == pytest.approx(0.7 * 0.5)


def test_a_torque_rate_within_its_allowance_costs_nothing():
    rates = dict.fromkeys(NAMES, 0.0) | {"torque_rate": 0.2}
    assert Evaluation(0.9, rates).objective == pytest.approx(1.9)
    assert Evaluation(0.9, rates | {"torque_rate": 0.5}).objective == pytest.approx(0.9 * 0.7)


@pytest.mark.parametrize(
    ("name", "change"),
    [
        ("position", {"q": (3, -0.1)}),
        ("velocity", {"dq": (0, 2.7)}),
        ("torque", {"torque": (6, 12.5), "before": (6, 12.0)}),
        ("torque_rate", {"torque": (2, 11.0), "before": (2, 1.0)}),
    ],
)
def test_each_limit_is_noticed_alone(name, change):
    values = {key: np.zeros((2, 7)) for key in ("q", "dq", "torque", "before")}
    values["q"][:] = ROBOT.home
    for key, (joint, value) in change.items():
        values[key][1, joint] = value
    found = violations(
        values["q"], values["dq"], values["torque"], values["before"], Limits.of(ROBOT, 0.01)
    )
    assert not found[0].any()
    assert [NAMES[i] for i in np.flatnonzero(found[1])] == [name]


def test_a_joint_that_rests_against_a_stop_at_home_is_no_violation_and_beyond_it_is():
    robot = make_robot("unitree_g1")
    finger, home = robot.joints.index("left_four_joint"), robot.home
    assert robot.position_limit[finger, 1] == home[finger]
    off = np.tile(home, (3, 1))
    off[1, finger] += AT_REST_RAD / 2
    off[2, finger] += AT_REST_RAD * 2
    still = np.zeros_like(off)
    found = violations(off, still, still, still, Limits.of(robot, 0.01))
    assert found[:, LIMITS.index("position")].tolist() == [False, False, True]


def test_where_home_is_within_the_ranges_the_limits_are_the_ranges():
    limits = Limits.of(ROBOT, 0.01)
    np.testing.assert_array_equal([limits.lowest, limits.highest], ROBOT.position_limit.T)
