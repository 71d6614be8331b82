import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from t2l.advise.loop import (
    MOST_MARGIN,
    Plant,
    Signals,
    closed,
    lag_s,
    margin,
    overshoot,
    radius,
    ring,
    sampled,
)
from t2l.advise.machine import of_model
from t2l.identify.model import Model
from tests.advise.stepped import stepped
from tests.conftest import ROOT

ARM = str(ROOT / "examples/two_joint_arm/two_joint_arm.xml")
JOINTS = ("shoulder", "elbow")
POSE = np.array([0.4, 0.7])
RATE = 500.0
EFFECTS = {
    "none": {},
    "torque late": {"torque_delay": {"delay": 0.0034}},
    "measurements late": {"measurement_delay": {"delay": 0.006}},
    "commands late": {"command_delay": {"delay": 0.011}},
    "motor lags": {"actuator_bandwidth": {"cutoff": {"shoulder": 30.0, "elbow": 50.0}}},
    "velocity smoothed": {"velocity_filter": {"cutoff": 25.0}},
    "gains": {
        "controller_gains": {
            "kp_factor": {"shoulder": 0.7, "elbow": 1.2},
            "kd_factor": {"shoulder": 1.3, "elbow": 0.8},
        }
    },
    "springs": {
        "joint_flexibility": {
            "stiffness": {"shoulder": 200.0, "elbow": 90.0},
            "damping": {"shoulder": 0.1, "elbow": 0.05}, "encoder_on_link": 0.0,
        }
    },
    "springs, encoders on links": {
        "joint_flexibility": {
            "stiffness": {"shoulder": 400.0, "elbow": 200.0},
            "damping": {"shoulder": 0.4, "elbow": 0.2}, "encoder_on_link": 1.0,
        }
    },
    "all": {
        "torque_delay": {"delay": 0.003},
        "actuator_bandwidth": {"cutoff": {"shoulder": 60.0, "elbow": 40.0}},
        "velocity_filter": {"cutoff": 60.0},
        "armature": {"inertia": {"shoulder": 0.01, "elbow": 0.004}},
        "viscous_friction": {"damping": {"shoulder": 0.05, "elbow": 0.03}},
    },
}  # fmt: skip


def one(mass, period=0.001, damping=0.0, stiffness=0.0):
    """A plant of one joint over a tick."""
    cell = np.full((1, 1, 1), 1.0)
    plant = Plant(
        mass * cell, np.full((1, 1), damping), stiffness * cell, np.eye(1), np.eye(1)
    )  # fmt: skip
    return sampled(plant, period)


def gains(kp, kd):
    return np.full((1, 1), kp), np.full((1, 1), kd)


MASS, DAMP = st.floats(0.005, 5), st.floats(0.05, 3)
HZ = st.floats(0.3, 10)


@given(mass=MASS, zeta=st.floats(0.05, 0.9), hz=HZ)
def test_a_fast_loop_rings_as_the_textbook_says(mass, zeta, hz):
    omega = 2 * np.pi * hz
    kp, kd = mass * omega**2, 2 * zeta * mass * omega
    # a held torque is late by half a tick, which takes h/2 of Kp from the damping
    loop = closed(one(mass, 1e-5), *gains(kp, kd), Signals.ideal(1e-5, 1))
    found = ring(loop)
    assert found.hz[0] == pytest.approx(hz * np.sqrt(1 - zeta**2), rel=2e-3)
    assert found.damping[0] == pytest.approx(zeta, abs=2e-3)
    passes = np.exp(-np.pi * zeta / np.sqrt(1 - zeta**2))
    assert overshoot(loop, np.array([hz]))[0] == pytest.approx(passes, abs=3e-3)
    assert lag_s(loop)[0, 0] == pytest.approx(kd / kp, rel=1e-2, abs=1e-5)


@given(mass=MASS, hz=HZ, zeta=DAMP, delay=st.floats(0, 0.01), factor=st.floats(0.01, 100))
def test_to_scale_masses_torques_and_gains_changes_nothing(mass, hz, zeta, delay, factor):
    omega = 2 * np.pi * hz
    signals = Signals(0.001, *(np.array([x]) for x in (delay, 0.0, 80.0, 50.0)))

    def seen(scale):
        plant = one(scale * mass, damping=scale * 0.1 * mass, stiffness=scale * mass)
        both = gains(scale * mass * omega**2, scale * 2 * zeta * mass * omega)
        loop = closed(plant, *both, signals)
        return radius(loop)[0], lag_s(loop)[0, 0], margin(plant, *both, signals)[0]

    assert seen(factor) == pytest.approx(seen(1.0), rel=1e-6, abs=1e-9)


@given(mass=MASS, damps=st.floats(0.05, 1.9), holds=st.floats(0.001, 1.9))
def test_without_effects_the_margin_is_that_of_jurys_criterion(mass, damps, holds):
    h = 0.001
    kd = damps * mass / h
    kp = holds * kd / h
    found = margin(one(mass), *gains(kp, kd), Signals.ideal(h, 1))[0]
    expected = 2 * mass / (kd * h)
    assume(abs(expected - 1) > 1e-3)
    if expected < 1:
        assert found == 0
    else:
        assert found == pytest.approx(min(expected, MOST_MARGIN), rel=1e-3)


def test_a_delay_costs_margin_and_no_lag_of_its_own():
    """On a ramp all torques are alike: what is late is late by nothing."""
    h, none, inf = 0.001, np.zeros(1), np.full(1, np.inf)
    plant, both = one(0.1), gains(100.0, 4.0)
    ideal, late = Signals.ideal(h, 1), Signals(h, np.array([0.008]), none, inf, inf)
    assert margin(plant, *both, late)[0] < margin(plant, *both, ideal)[0] / 2
    lags = [lag_s(closed(plant, *both, s))[0, 0] for s in (ideal, late)]
    assert lags[1] == pytest.approx(lags[0], rel=1e-6)


@pytest.mark.parametrize("effects", list(EFFECTS.values()), ids=list(EFFECTS))
@pytest.mark.parametrize(("kp", "kd"), [(20.0, 0.4), (60.0, 0.8)])
def test_the_linear_loop_moves_as_the_simulated_one(effects, kp, kd):
    model = Model(ARM, effects)
    machine = of_model(model, JOINTS, POSE[None], RATE, True)
    size = np.array([1e-3, -0.5e-3])
    truth = stepped(model, JOINTS, POSE, np.full(2, kp), np.full(2, kd), size, RATE, 0.6)
    factors = machine.gain_factor.T
    loop = closed(
        sampled(machine.plant, 1 / RATE), kp * factors[:1], kd * factors[1:], machine.signals
    )
    x, told = np.zeros(loop.f.shape[1]), []
    late = machine.signals.command_delay_s[0] * RATE
    # where measurements are late, the loop's own clock is behind
    sooner = round(max(-late, 0))
    for k in range(-sooner, len(truth)):
        told.append(loop.h @ x)
        share = np.clip(k + 1 - late, 0.0, 1.0)
        x = loop.f[0] @ x + loop.g[0] @ (size * share)
    assert np.abs(np.array(told)[sooner:] - truth).max() < 0.03 * np.abs(truth).max()


@pytest.mark.parametrize("effects", ["none", "torque late", "motor lags", "all"])
def test_the_simulation_diverges_beyond_the_predicted_limit_and_not_before(effects):
    model = Model(ARM, EFFECTS[effects])
    machine = of_model(model, JOINTS, POSE[None], RATE, True)
    kp, kd = np.array([60.0, 40.0]), np.array([1.2, 0.8])
    factors = machine.gain_factor.T
    limit = margin(
        sampled(machine.plant, 1 / RATE), kp * factors[:1], kd * factors[1:], machine.signals
    )[0]
    assert 1.2 < limit < MOST_MARGIN

    def grows(share):
        gain = share * limit
        size = np.full(2, 1e-5)
        q = stepped(model, JOINTS, POSE, gain * kp, gain * kd, size, RATE, 4.0)
        # what grows may end in a limit cycle, as the arm is not linear
        return not np.isfinite(q).all() or np.abs(q[-500:] - size).max() > 10 * size.max()

    assert grows(1.05)
    assert not grows(0.95)


@pytest.mark.parametrize(("kp", "kd"), [(10.0, 0.1), (30.0, 0.5), (80.0, 0.5), (15.0, 3.0)])
def test_ring_and_overshoot_of_a_simulated_step(kp, kd):
    """One joint, the other held, by what an engineer reads off a plot."""
    model, joints, pose = Model(ARM), ("elbow",), np.array([0.7])
    machine = of_model(model, joints, pose[None], RATE, True)
    both = gains(kp, kd)
    loop = closed(sampled(machine.plant, 1 / RATE), *both, machine.signals)
    natural = np.sqrt(kp / machine.inertia[:, 0]) / (2 * np.pi)
    q = stepped(model, joints, pose, *(g[0] for g in both), np.array([1e-3]), RATE, 3.0)[:, 0]
    assert overshoot(loop, natural)[0] == pytest.approx(max(q.max() / 1e-3 - 1, 0), abs=0.02)
    found = ring(loop)
    crossings = np.flatnonzero(np.diff(np.sign(q - 1e-3)))[:8]
    if found.damping[0] < 0.5:
        period = 2 * np.diff(crossings).mean() / RATE
        assert found.hz[0] == pytest.approx(1 / period, rel=0.03)


def test_what_dies_within_a_tick_does_not_ring():
    """A loop with a delay has fast modes; what an engineer sees is the slow one."""
    late = Signals(0.001, np.array([0.018]), *(np.full(1, x) for x in (0.0, np.inf, np.inf)))
    found = ring(closed(one(2.0), *gains(4.0, 1.2), late))
    assert found.hz[0] == pytest.approx(np.sqrt(4.0 / 2.0) / (2 * np.pi), rel=0.05)
    chatters = ring(closed(one(0.1), *gains(4.0, 210.0), Signals.ideal(0.001, 1)))
    assert chatters.hz[0] == pytest.approx(500)
    assert chatters.damping[0] < 0


@settings(max_examples=20)
@given(kp=st.floats(5, 200), kd=st.floats(0.1, 5))
def test_joints_that_do_not_touch_are_as_alone(kp, kd):
    mass = np.diag([0.1, 0.02])[None]
    plant = Plant(mass, np.zeros((1, 2)), 0 * mass, np.eye(2), np.eye(2))
    both = np.full((1, 2), kp), np.full((1, 2), kd)
    together = radius(closed(sampled(plant, 0.001), *both, Signals.ideal(0.001, 2)))[0]
    alone = [
        radius(closed(one(m), *gains(kp, kd), Signals.ideal(0.001, 1)))[0] for m in (0.1, 0.02)
    ]
    assert together == pytest.approx(max(alone), rel=1e-6)
