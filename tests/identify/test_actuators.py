import dataclasses

import numpy as np
import pytest

from t2l.identify.actuators import IdentificationError, identify
from t2l.recordings.recording import Recording
from t2l.robots import make_robot
from t2l.robots.plant import position_controlled
from t2l.sim.training_simulator import Simulator
from tests.defaults import identification


def made(stiffness=60.0, damping=6.0, **changes) -> Recording:
    """A second of the simulator itself."""
    robot = make_robot("fr3")
    simulator = Simulator(position_controlled(robot), robot.joints, robot.torque_limit, 1, 100)
    simulator.set_parameters(
        {
            "stiffness": stiffness, "damping": damping, "armature": 0.15,
            "static_friction": 0.3, "dynamic_friction_ratio": 0.8, "viscous_friction": 0.4,
        }
    )  # fmt: skip
    time = np.arange(50) / 50
    q_des = robot.home + 0.1 * np.sin(np.pi * time)[:, None]
    q, dq = simulator.simulate(q_des, robot.home, 0.0, nstep=2)
    recording = Recording(
        name="made", path=None, robot="fr3", joints=robot.joints, kp=np.full(7, 64.0),
        kd=np.full(7, 8.0), command_rate_hz=50.0, control_rate_hz=1000.0,
        gravity_compensation=True, time=time, q_des=q_des, q=q[0], dq=dq[0],
    )  # fmt: skip
    return dataclasses.replace(recording, **changes)


def test_the_motion_is_reproduced_and_the_loss_never_rises():
    recording = made()
    found = identify(recording, identification(iterations=300, population=20), seed=0)
    swing = np.mean((recording.q - recording.q.mean(axis=0)) ** 2)
    assert found.mse < 2e-3 * swing
    assert np.all(np.diff(found.losses) <= 0)
    assert len(found.losses) == 300
    np.testing.assert_allclose(np.mean((found.q - recording.q) ** 2), found.mse)


def test_the_same_seed_finds_the_same():
    settings = identification(iterations=3, population=8)
    first, again = (identify(made(), settings, seed=7, threads=n) for n in (1, 2))
    np.testing.assert_array_equal(first.losses, again.losses)
    assert identify(made(), settings, seed=8).losses[-1] != first.losses[-1]


def test_positions_alone_suffice_where_velocity_was_not_logged():
    found = identify(made(dq=None), identification(iterations=3, population=8), seed=0)
    assert np.isfinite(found.losses).all()


@pytest.mark.parametrize(
    ("recording", "message"),
    [
        (made(command_rate_hz=30.0), "command_rate_hz: found 30; allowed: a divisor"),
        (made(q=np.full((50, 7), np.nan)), "q: found 0 rows"),
    ],
)
def test_a_recording_that_does_not_fit_is_refused(recording, message):
    with pytest.raises(IdentificationError, match=message):
        identify(recording, identification(iterations=1, population=4), seed=0)
