"""Second order within a tick: a motor at its limit, drag."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from t2l.effects.quadratic_friction import QuadraticFriction
from t2l.effects.torque_speed_limit import TorqueSpeedLimit
from t2l.robots import plant
from tests.diagnose.made import DAMPING, INERTIA, WEIGHT, pendulum, swing
from tests.sim.test_servo import loop

PERIOD_S = 0.002  # a physics step a millisecond, so two a tick
STIFF = np.array([[80.0, 0.5]])
TICKS = 300


def swung(tmp_path, install, substeps=1):
    """Positions (ticks,) of a pendulum that is led quickly to and fro."""
    model = plant.load(pendulum(tmp_path), ["hinge"]).compile()
    made = loop(model, STIFF, TICKS, substeps, PERIOD_S, swing(0.8, 2.5))
    install(made)
    return made.run()[0][0, 0, :, 0]


def with_effect(effect, **values):
    every = {name: np.full((1, 1), value) for name, value in values.items()}
    return lambda made: effect.install(made, slice(0, 1), np.array([0]), every)


def exact(torque_of):
    """The same, of the equation: `torque_of` (held torque, velocity) acts on the joint."""
    commands = swing(0.8, 2.5)(np.arange(TICKS + 1) * PERIOD_S)
    state, found, (kp, kd) = np.array([0.3, 0.5]), np.empty(TICKS + 1), STIFF[0]
    for tick, command in enumerate(commands):
        found[tick] = state[0]
        held = kp * (command - state[0]) - kd * state[1]

        def motion(_, x, held=held):
            torque = torque_of(held, x[1]) - DAMPING * x[1] - WEIGHT * np.sin(x[0])
            return x[1], torque / INERTIA

        state = solve_ivp(
            motion, (0.0, PERIOD_S), state, rtol=1e-10, atol=1e-12, max_step=PERIOD_S / 20
        ).y[:, -1]
    return found


STALL, FASTEST, DRAG = 6.0, 4.0, 0.3


def limited(held, dq):
    return np.clip(held, -STALL - STALL / FASTEST * dq, STALL - STALL / FASTEST * dq)


@pytest.mark.parametrize(
    ("effect", "torque_of"),
    [
        (with_effect(TorqueSpeedLimit(), stall_torque=STALL, no_load_speed=FASTEST), limited),
        (
            with_effect(QuadraticFriction(), coefficient=DRAG),
            lambda held, dq: held - DRAG * dq * abs(dq),
        ),
    ],
    ids=["a motor at its limit", "drag"],
)
def test_torques_of_velocity_are_those_of_the_middle_of_a_tick(tmp_path, effect, torque_of):
    wanted = exact(torque_of)
    # what it does, so that an error is a share of that
    does = np.abs(wanted - exact(lambda held, dq: held)).max()
    assert np.abs(swung(tmp_path, effect) - wanted).max() < 2e-3 * does
