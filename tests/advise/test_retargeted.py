import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from t2l.advise.retargeted import commands, held_steps, labels, moving_most, replayed
from t2l.advise.shown import RECORDED, Shown, free_torques
from t2l.errors import ConfigurationError
from t2l.identify.model import Model
from t2l.identify.prediction import with_effects
from tests.advise.made import ARM, JOINTS, motion

RATE = 500.0
WIDE = np.full((2, 2), (-np.inf, np.inf))
PLANT = with_effects(Model(ARM).robot, JOINTS)
LIMIT = np.full(2, 5.0)


@pytest.fixture(scope="module")
def shown():
    q = [motion(i, RATE, 1.0) for i in range(4)]
    dq = [np.gradient(one, 1 / RATE, axis=0) for one in q]
    torque = free_torques(PLANT, JOINTS, q, dq, RATE, weighs=False)
    return Shown(RATE, q, dq, torque, q, RECORDED)


def gains(kp, kd):
    return np.array(kp)[:, None] * np.ones(2), np.array(kd)[:, None] * np.ones(2)


def replay(shown, kp, kd, policy_rate_hz, model=None, factor=1.0):
    motions = moving_most(shown, lambda q, dq: free_torques(PLANT, JOINTS, q, dq, RATE, False))
    return replayed(
        model or Model(ARM), JOINTS, motions, RATE, *gains(kp, kd), policy_rate_hz, 1000.0, True,
        LIMIT, factor,
    )  # fmt: skip


def test_on_a_ramp_commands_run_ahead_by_damping_over_stiffness():
    t = np.arange(100)[:, None] / RATE * np.ones(2)
    found = commands(t, np.ones((100, 2)), np.zeros((100, 2)), *gains([50.0], [5.0]), 1)
    assert found[0] == pytest.approx(t + 0.1)


@given(factor=st.floats(0.01, 100), kp=st.floats(1, 1000), kd=st.floats(0, 100))
def test_to_scale_torques_and_gains_changes_no_command(factor, kp, kd):
    q, dq, torque = np.random.default_rng(0).normal(size=(3, 30, 2))
    one = commands(q, dq, torque, *gains([kp], [kd]), 10)
    other = commands(q, dq, factor * torque, *gains([factor * kp], [factor * kd]), 10)
    np.testing.assert_allclose(other, one, rtol=1e-9, atol=1e-9)


def test_labels_grow_as_stiffness_falls_and_leave_the_range(shown):
    ranges = np.array([[-np.inf, 0.75], [-np.inf, np.inf]])
    told = labels(shown, *gains([2.0, 20.0, 200.0], [1.0] * 3), 10, ranges, np.full(2, 3.0))
    assert (np.diff(told.lead_rad, axis=0) < 0).all()
    assert (told.roughness_rad[0] > told.roughness_rad[2]).all()
    assert told.beyond[0, 0] > 0.1
    assert told.beyond[2, 0] < told.beyond[0, 0]
    assert not told.beyond[:, 1].any()
    assert told.fast[0].max() > 0
    assert not told.fast[2].any()


def test_commands_at_the_rate_of_the_loop_lead_the_arm_as_shown(shown):
    found = replay(shown, [20.0, 100.0], [1.0, 4.0], RATE)
    assert found.rmse_rad.max() < 2e-3


def test_held_for_longer_they_lead_it_less_well_and_with_more_torque(shown):
    quick, slow = (replay(shown, [100.0], [2.0], rate) for rate in (100.0, 10.0))
    assert (slow.rmse_rad > 2 * quick.rmse_rad).all()
    assert slow.saturated.max() > quick.saturated.max()


def test_friction_of_the_machine_is_seen_where_stiffness_is_low(shown):
    rubs = Model(ARM, {"coulomb_friction": {"torque": {"shoulder": 0.3, "elbow": 0.3}}})
    bare, rough = (replay(shown, [10.0, 200.0], [1.0, 4.0], 50.0, m) for m in (None, rubs))
    more = rough.rmse_rad - bare.rmse_rad
    assert (more[0] > 5 * np.abs(more[1])).all()


def test_commands_are_made_for_the_gains_that_the_machine_has(shown):
    each = {"shoulder": 0.5, "elbow": 0.5}
    weak = Model(ARM, {"controller_gains": {"kp_factor": each, "kd_factor": each}})
    own = replay(shown, [50.0], [2.0], 100.0)
    told = replay(shown, [100.0], [4.0], 100.0, weak, np.full((2, 2), 0.5))
    np.testing.assert_allclose(told.rmse_rad, own.rmse_rad, rtol=1e-6)
    wrong = replay(shown, [100.0], [4.0], 100.0, weak)
    assert (wrong.rmse_rad > told.rmse_rad).all()


def test_what_runs_away_has_an_infinite_error(shown):
    late = Model(ARM, {"torque_delay": {"delay": 0.02}})
    found = replay(shown, [20.0, 4000.0], [1.0, 1.0], 50.0, late)
    assert np.isfinite(found.rmse_rad[0]).all()
    assert (found.rmse_rad[1] > 0.3).all()


def test_a_policy_faster_than_what_was_recorded_is_refused():
    assert held_steps(500, 50) == 10
    with pytest.raises(
        ConfigurationError, match="--policy-rate: found 50 Hz; allowed: up to 20 Hz"
    ):
        held_steps(20, 50)
