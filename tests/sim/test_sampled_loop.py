import numpy as np
import pytest

from t2l.sim.sampled_loop import chatter, damping_number, transition

PERIOD_S = 0.01


def step(mass, kp, kd, damping=0.0, stiffness=0.0, period_s=PERIOD_S):
    """Of joints in one loop: each argument one number, or one a joint."""
    mass = np.atleast_2d(mass)
    n = len(mass)
    each = [np.broadcast_to(values, (1, n)) for values in (damping, stiffness, kp, kd)]
    return transition(mass[None], *each, np.array([period_s]))


def radius(matrix):
    return np.abs(np.linalg.eigvals(matrix)).max()


@pytest.mark.parametrize("kp", [1.0, 30.0, 150.0])
@pytest.mark.parametrize("kd", [0.01, 0.1, 0.9, 1.5, 1.99, 2.01, 4.27])
def test_one_joint_settles_as_jury_says(kp, kd):
    """Kp h/2 < Kd and Kd h/M < 2, here with M = h = 0.01."""
    stable = kp * PERIOD_S / 2 < kd < 2
    assert (radius(step(0.01, kp, kd)) < 1) == stable


def test_chatter_is_what_alternates():
    """A loop of too little damping swings ever wider, but slowly: friction may hold that."""
    assert radius(step(0.01, 30.0, 0.01)) > 1
    assert chatter(step(0.01, 30.0, 0.01)) == 0
    assert chatter(step(0.01, 30.0, 4.27)) == pytest.approx(3.3, abs=0.2)
    # no Kd settles that: the joint would swing within four ticks
    assert min(chatter(step(0.01, 500.0, kd))[0] for kd in np.linspace(0, 3, 31)) > 1


def test_a_tick_is_exact():
    """Against steps of a thousandth of it, under the torque of its beginning."""
    mass, damping, stiffness, kp, kd = 0.02, 0.3, 5.0, 8.0, 0.1
    q, dq, dt = 0.3, -1.0, PERIOD_S / 1000
    torque = -kp * q - kd * dq
    for _ in range(1000):
        middle = q + 0.5 * dt * dq
        dq += dt * (torque - damping * dq - stiffness * middle) / mass
        q = middle + 0.5 * dt * dq
    found = step(mass, kp, kd, damping, stiffness)[0] @ [0.3, -1.0]
    np.testing.assert_allclose(found, [q, dq], rtol=1e-4)


def test_a_light_link_is_shaken_by_the_joint_that_carries_it():
    """Each alone would settle; together the inertia that moves against both gains is less."""
    mass, kd = np.array([[0.011, 0.009], [0.009, 0.01]]), np.array([1.0, 1.0])
    assert (kd * PERIOD_S / np.diag(mass) < 2).all()
    assert chatter(step(mass, 1.0, kd)) > 1
    number, joint = damping_number(mass, kd, PERIOD_S)
    assert number > 2
    assert joint == 1
    # 2 M/h − Kd is positive definite exactly where nothing alternates
    scale = number / 2
    assert chatter(step(mass, 1.0, 1.001 * kd / scale)) > 1
    assert chatter(step(mass, 1.0, 0.999 * kd / scale)) < 1


def test_damping_of_the_joint_helps():
    assert chatter(step(0.01, 1.0, 2.02)) > 1
    assert chatter(step(0.01, 1.0, 2.02, damping=0.5)) < 1
