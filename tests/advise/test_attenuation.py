import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from t2l.advise.attenuation import (
    attenuation,
    continuous_matrices,
    effective_error,
    held_variance,
    step_matrices,
    time_constant_s,
)

STIFFNESS = st.floats(1, 5000)
DAMPING = st.floats(0.5, 500)
INERTIA = st.floats(0.01, 5)


def test_the_theorem_with_its_hold():
    # 0.02 s × 100 / (2 × 10) = 0.1
    assert attenuation(100, 10, 0.02) == pytest.approx(0.1)
    # √0.1 × 0.2 rad
    assert effective_error(100, 10, 0.04, 0.02) == pytest.approx(0.0632456, rel=1e-5)


def test_a_joint_without_inertia_is_a_moving_average():
    """q' = q + β (a − q) has the variance β / (2 − β)."""
    kp, kd, dt = 300.0, 7.0, 0.01
    share = dt * kp / (kd + dt * kp)
    assert held_variance(*step_matrices(kp, kd, 1e-12, dt), 1) == pytest.approx(share / (2 - share))


@settings(max_examples=25)
@given(kp=STIFFNESS, kd=DAMPING, inertia=INERTIA, steps=st.integers(1, 30))
def test_the_lyapunov_value_is_the_sum_over_all_earlier_commands(kp, kd, inertia, steps):
    assume(time_constant_s(kp, kd, inertia, 0.002) < 0.5)
    a, b = step_matrices(kp, kd, inertia, 0.002)
    count = int(15 * time_constant_s(kp, kd, inertia, 0.002) / 0.002) + 2 * steps
    # the response to one command: pushed for a hold, then left alone
    x, response = np.zeros(2), []
    for k in range(count):
        x = a @ x + (b if k < steps else 0)
        response.append(x[0])
    # at every timestep, the squares of the responses to this command and all earlier ones
    total = np.sum(np.square(response)) / steps
    assert held_variance(a, b, steps) == pytest.approx(total, rel=1e-3)


@given(kp=STIFFNESS, kd=DAMPING, inertia=INERTIA, heavier=st.floats(1, 10))
def test_where_the_theorem_is_small_it_holds_whatever_the_inertia(kp, kd, inertia, heavier):
    theorem = attenuation(kp, kd, 0.02)
    assume(theorem < 0.1)
    for mass in (inertia, inertia * heavier):
        exact = held_variance(*step_matrices(kp, kd, mass, 0.002), 10)
        assert exact == pytest.approx(theorem, rel=0.1)


@pytest.mark.parametrize(("kp", "kd", "inertia"), [(512, 8, 0.1), (2048, 2, 0.05), (32, 32, 0.5)])
def test_with_fine_timesteps_the_simulated_joint_is_the_continuous_one(kp, kd, inertia):
    coarse, fine = (
        held_variance(*step_matrices(kp, kd, inertia, 0.02 / n), n) for n in (1000, 2000)
    )
    continuous = held_variance(*continuous_matrices(kp, kd, inertia, 0.02 / 100), 100)
    # the integrator is of first order: its error halves with the timestep
    assert 2 * fine - coarse == pytest.approx(continuous, rel=1e-2)


def test_the_integrator_damps_by_a_timestep_of_stiffness():
    kp, inertia = 2048.0, 0.5
    damped = kp * 0.002
    simulated = held_variance(*step_matrices(kp, 8.0, inertia, 0.002), 10)
    assert simulated == pytest.approx(
        held_variance(*continuous_matrices(kp, 8.0 + damped, inertia, 0.002), 10), rel=0.05
    )


@settings(max_examples=15)
@given(kp=STIFFNESS, kd=DAMPING, inertia=INERTIA, factor=st.floats(0.01, 100))
def test_to_scale_masses_and_gains_changes_nothing(kp, kd, inertia, factor):
    one = held_variance(*step_matrices(kp, kd, inertia, 0.002), 10, 0.5)
    scaled = (factor * x for x in (kp, kd, inertia))
    assert held_variance(*step_matrices(*scaled, 0.002), 10, 0.5) == pytest.approx(one, rel=1e-6)


@pytest.mark.parametrize("correlation", [0.0, 0.7, 0.95])
def test_correlated_errors_as_drawn(correlation):
    rng, a, b = np.random.default_rng(3), *step_matrices(200.0, 10.0, 0.3, 0.002)
    n, steps, holds = 400, 10, 400
    x, error, seen = np.zeros((n, 2)), rng.normal(size=n), []
    for hold in range(holds):
        for _ in range(steps):
            x = x @ a.T + error[:, None] * b
            if hold >= holds // 4:
                seen.append(np.mean(x[:, 0] ** 2))
        fresh = np.sqrt(1 - correlation**2) * rng.normal(size=n)
        error = correlation * error + fresh
    # 120,000 holds, of which some tens at a time are alike
    assert held_variance(a, b, steps, correlation) == pytest.approx(np.mean(seen), rel=0.05)


def test_an_error_that_stays_is_followed_whole():
    a, b = step_matrices(200.0, 10.0, 0.3, 0.002)
    assert held_variance(a, b, 10, 1 - 1e-9) == pytest.approx(1.0, rel=1e-4)
