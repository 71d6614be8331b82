from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from t2l.advise.exclusions import (
    BEYOND,
    KINDS,
    LEAST_MARGIN,
    NEAR,
    RINGS,
    SAGS,
    SATURATED,
    UNSTABLE,
    mildest,
    objections,
)
from t2l.advise.loop import MOST_MARGIN
from t2l.advise.machine import of_model
from t2l.advise.responses import LONGEST_DELAY_S, longest_delay_s, responses
from t2l.advise.retargeted import Labels, Replayed
from t2l.identify.model import Model
from tests.advise.made import ARM, JOINTS

POSES = np.array([[0.4, 0.7], [0.1, -0.5]])
LATE = {"torque_delay": {"delay": 0.018}}


def machine(compensated=True, **effects):
    return of_model(Model(ARM, effects), JOINTS, POSES, 1000.0, compensated)


def gains(kp, kd):
    return np.array(kp)[:, None] * np.ones(2), np.array(kd)[:, None] * np.ones(2)


def why(told, joint=0, kind=None):
    return [one.why for one in told if one.joint == joint and kind in (None, one.kind)]


@settings(max_examples=20)
@given(factor=st.floats(0.01, 100))
def test_to_scale_masses_torques_and_gains_changes_no_response(factor):
    one = machine(False, torque_delay={"delay": 0.004}, viscous_friction={
        "damping": {"shoulder": 0.1, "elbow": 0.1}
    })  # fmt: skip
    plant = one.plant
    scaled = replace(
        one,
        plant=replace(
            plant, mass=factor * plant.mass, damping=factor * plant.damping,
            stiffness=factor * plant.stiffness,
        ),
        weight=factor * one.weight, friction=factor * one.friction,
    )  # fmt: skip
    kp, kd = gains([10.0, 40.0], [0.3, 2.0])
    first, second = responses(one, kp, kd), responses(scaled, factor * kp, factor * kd)
    for key in ("natural_hz", "ring_hz", "damping", "lag_s", "overshoot", "margin", "sag_rad"):
        np.testing.assert_allclose(
            getattr(second, key), getattr(first, key), rtol=1e-5, atol=1e-9, err_msg=key
        )
    assert (first.together == second.together).all()


def test_what_rings_says_how_fast_and_by_what():
    told = objections(
        one := machine(), *gains([30.0], [0.05]), responses(one, *gains([30.0], [0.05]))
    )
    assert [x.kind for x in told] == [RINGS, RINGS]
    hz = np.sqrt(30 / one.inertia[:, 0].mean()) / (2 * np.pi)
    (text,) = why(told)
    assert text.startswith("shoulder at Kp 30, Kd 0.05 rings at ")
    assert float(text.split(" Hz")[0].split()[-1]) == pytest.approx(hz, rel=0.1)
    assert "because Kd damps its" in text


def test_what_rings_for_being_late_says_so():
    late, pair = machine(**LATE), gains([20.0], [0.9])
    (text,) = why(objections(late, *pair, responses(late, *pair)))
    assert " rings at " in text
    assert text.endswith("because torques and measurements come 18 ms late")
    assert not objections(machine(), *pair, responses(machine(), *pair))


def test_a_loop_too_slow_for_its_damping_is_near_unstable_and_then_is():
    one = machine()
    limit = 2 * one.inertia[:, 1].min() * one.rate_hz
    pair = gains([20.0, 20.0], [0.7 * limit, 1.2 * limit])
    told = objections(one, *pair, responses(one, *pair))
    assert [x.kind for x in told if x.joint == 1] == [NEAR, UNSTABLE]
    assert "a loop of 1000 Hz is slow for so much damping" in why(told, 1, NEAR)[0]


def test_a_loop_too_slow_for_its_stiffness_says_so():
    slow = of_model(Model(ARM), JOINTS, POSES, 50.0, True)
    pair = gains([20.0], [0.11])
    told = objections(slow, *pair, responses(slow, *pair))
    assert {x.kind for x in told} == {UNSTABLE}
    assert "a loop of 50 Hz is slow for so much stiffness" in why(told)[0]


def test_an_arm_that_nobody_carries_sags_by_its_weight_over_stiffness():
    hangs, pair = machine(compensated=False), gains([5.0, 200.0], [0.5, 3.0])
    found = responses(hangs, *pair)
    assert found.sag_rad[0] == pytest.approx(40 * found.sag_rad[1])
    told = objections(hangs, *pair, found)
    assert [(x.cell, x.kind) for x in told if x.joint == 0] == [(0, SAGS)]
    assert "sags by up to" in why(told)[0]
    assert "its weight" in why(told)[0]


def test_what_demonstrations_ask_for_rules_out_too():
    one, pair = machine(), gains([20.0], [1.5])
    found = responses(one, *pair)
    some = np.array([[0.3, 0.0]])
    labels = Labels(some, some, some, 0 * some)
    replay = Replayed(some, some[:, ::-1])
    told = objections(one, *pair, found, labels, replay)
    assert [(x.joint, x.kind) for x in told] == [(0, BEYOND), (1, SATURATED)]
    assert "30 % of the demonstrations' time" in told[0].why
    gone = objections(one, *pair, found, None, Replayed(some + np.inf, some))
    assert "runs away" in gone[0].why


def test_the_mildest_of_each_joint_and_kind_is_told_with_their_number():
    one, pair = machine(), gains([30.0, 30.0, 20.0], [0.05, 0.2, 1.5])
    told = objections(one, *pair, responses(one, *pair))
    (first, count), *_ = mildest(told, 2)
    assert (first.cell, first.kind, count) == (1, RINGS, 2)
    assert {x.kind for x in told} <= set(KINDS)


def test_the_longest_delay_is_where_the_margin_ends():
    one, pair = machine(), gains([20.0], [1.5])
    bears = longest_delay_s(one, pair[0][0], pair[1][0], LEAST_MARGIN)
    assert (bears > 0).all()
    assert (bears < LONGEST_DELAY_S).all()

    def margins(delay):
        return responses(machine(torque_delay={"delay": delay}), *pair).margin[0]

    elbow = bears[1]
    assert margins(0.9 * elbow)[1] > LEAST_MARGIN > margins(1.1 * elbow)[1]
    slack = longest_delay_s(one, np.full(2, 0.5), np.full(2, 0.3), LEAST_MARGIN)
    assert (slack >= bears).all()
    assert responses(one, *pair).margin.max() <= MOST_MARGIN
