"""Hidden sides of joints that give."""

import numpy as np
import pytest

from t2l.sim.transmission import Transmission, hidden_motion

PERIOD_S = 1e-3
K, D, J = 40.0, 0.2, 0.1


def _gives(stiffness=K, damping=D, play=0.0, joints=1):
    shape = (1, 1, joints)
    return Transmission(*(np.full(shape, x) for x in (stiffness, damping, play, 0.0)))


def _moved(gives, inertia, torque):
    """e by what the hidden side is behind, from its acceleration, (ntick, k)."""
    ddq = hidden_motion(gives, inertia, torque, PERIOD_S)[0][:, 0, 0].astype(float)
    return np.cumsum(np.cumsum(ddq, axis=0) * PERIOD_S, axis=0) * PERIOD_S


def test_a_step_lets_it_swing_as_a_mass_on_a_spring_does():
    ticks = 2000
    torque = np.zeros((ticks, 1, 1, 1))
    torque[1:] = 1.0
    inertia = np.full((ticks, 1, 1, 1, 1), J)
    e = _moved(_gives(), inertia, torque)[:, 0]
    t = np.arange(ticks) * PERIOD_S
    rate = D / (2 * J)
    swing = np.sqrt(K / J - rate**2)
    wave = np.cos(swing * t) + rate / swing * np.sin(swing * t)
    assert np.allclose(e, (1 - np.exp(-rate * t) * wave) / K, atol=0.03 / K)


def test_it_begins_at_rest_under_its_load():
    torque, inertia = np.full((200, 1, 1, 1), -3.0), np.full((200, 1, 1, 1, 1), J)
    assert np.abs(hidden_motion(_gives(play=0.1), inertia, torque, PERIOD_S)[0]).max() < 1e-9


def test_within_the_play_nothing_holds_it():
    torque, inertia = np.full((300, 1, 1, 1), 1e-4), np.full((300, 1, 1, 1, 1), J)
    torque[:3] = -1e-4
    ddq = hidden_motion(_gives(play=0.2), inertia, torque, PERIOD_S)[0][:, 0, 0, 0]
    # first the teeth that were closed push too
    assert ddq[5] > 1.5e-4 / J
    assert np.allclose(ddq[200:], 1e-4 / J, rtol=1e-3)


@pytest.mark.parametrize("play", [0.0, 0.01])
def test_masses_that_do_not_couple_are_as_each_alone(play):
    rng = np.random.default_rng(0)
    torque = np.cumsum(rng.normal(size=(500, 1, 1, 3)), axis=0)
    masses = np.array([0.1, 0.3, 1.0])
    inertia = np.broadcast_to(np.diag(masses), (500, 1, 1, 3, 3))
    together = hidden_motion(_gives(play=play, joints=3), inertia, torque, PERIOD_S)[0]
    # the lightest asks for the shortest steps
    alone = hidden_motion(_gives(play=play), inertia[..., :1, :1], torque[..., :1], PERIOD_S)[0]
    assert np.allclose(together[..., :1], alone, rtol=1e-4, atol=1e-4)


def test_stiff_springs_lose_no_time_to_small_steps():
    """What swings too fast for the ticks follows its load, and stays bounded."""
    t = np.arange(400) * PERIOD_S
    torque = np.sin(20 * t)[:, None, None, None]
    inertia = np.full((400, 1, 1, 1, 1), J)
    gives = _gives(stiffness=1e7, damping=20.0)
    e = hidden_motion(gives, inertia, torque, PERIOD_S)[0]
    assert np.isfinite(e).all()
    assert np.abs(e[200:]).max() < 1e-3
