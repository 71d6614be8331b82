import dataclasses

import mujoco
import numpy as np
import pytest
from benchmarks.hidden_effects.cases import ROBOTS
from benchmarks.hidden_effects.generator import record

from t2l.effects.term import Layout
from t2l.identify.initial_state import start_state
from t2l.identify.model import Model
from t2l.identify.prediction import Predictor, Request
from t2l.recordings import Recording
from tests.diagnose.made import (
    hold,
    measured,
    pendulum,
    predict,
    recording,
    swing,
)

PLAIN = Request(Layout(()), np.zeros((1, 0)))


def generated(robot, duration_s=0.5, **settings) -> Recording:
    """A clean recording by an integration and a controller that share nothing with t2l."""
    setup = robot.setup
    kp, kd = setup.gains[1]
    home, size = np.array(robot.home), np.array(robot.amplitude)
    facts = {
        "gravity_compensation": settings.pop("gravity_compensation", setup.gravity_compensation),
        "control_rate_hz": settings.pop("control_rate_hz", 1000.0),
    }
    settings = {"sample_rate_hz": 100} | settings
    frame = record(
        robot.mjcf, robot.joints, kp, kd,
        lambda t: home + 0.5 * size * np.sin(2 * np.pi * 1.5 * t)[:, None],
        duration_s=duration_s, command_rate_hz=50,
        physics_rate_hz=4000, **facts, **settings,
    )  # fmt: skip

    def columns(kind):
        return frame[[f"{kind}.{joint}" for joint in robot.joints]].to_numpy()

    n = len(robot.joints)
    return Recording(
        name="clean", path=None, robot=str(robot.mjcf),
        joints=robot.joints, kp=np.broadcast_to(np.asarray(kp, float), n).copy(),
        kd=np.broadcast_to(np.asarray(kd, float), n).copy(), command_rate_hz=50.0,
        time=frame["time"].to_numpy(), q_des=columns("q_des"), q=columns("q"), **facts,
    )  # fmt: skip


def without_dry_friction(robot, folder):
    """What a joint does at the moment it stops is a question of its own."""
    spec = mujoco.MjSpec.from_file(str(robot.mjcf))
    for element in [*spec.actuators, *spec.keys, *spec.excludes]:
        spec.delete(element)
    for geom in [g for g in spec.geoms if g.type == mujoco.mjtGeom.mjGEOM_MESH]:
        spec.delete(geom)
    for mesh in list(spec.meshes):
        spec.delete(mesh)
    for joint in spec.joints:
        joint.frictionloss = 0.0
    path = folder / "smooth.xml"
    path.write_text(spec.to_xml())
    return dataclasses.replace(robot, mjcf=path)


@pytest.mark.parametrize(
    ("robot", "settings"),
    [
        ("pendulum", {}),
        ("pendulum", {"control_rate_hz": 250.0, "sample_rate_hz": 125}),
        ("two_joint_arm", {}),
        ("two_joint_arm", {"gravity_compensation": "continuous"}),
        ("two_joint_arm", {"control_rate_hz": 250.0, "sample_rate_hz": 125}),
        ("fr3", {"duration_s": 0.3}),
    ],
)
def test_a_clean_recording_of_an_independent_machine_is_predicted(tmp_path, robot, settings):
    made = generated(without_dry_friction(ROBOTS[robot], tmp_path), **settings)
    error = predict(made, substeps=4) - made.q[~np.isnan(made.q)]
    # an encoder of the best kind, 0.02 mrad, would not notice
    assert np.abs(error).max() < 2e-5


def test_between_the_ticks_of_a_slow_loop_a_joint_does_not_move_in_straight_lines():
    made = generated(ROBOTS["pendulum"], control_rate_hz=100.0, sample_rate_hz=1000)
    error = predict(made, substeps=4) - made.q[~np.isnan(made.q)]
    assert np.abs(error).max() < 1e-4


def test_velocity_is_the_slope_of_position(tmp_path):
    made = recording(pendulum(tmp_path), swing(), row_rate_hz=1000.0, duration_s=0.5)
    (q,), (dq,) = Predictor(made.robot, [made]).predict([PLAIN], velocity=True)
    np.testing.assert_allclose(dq[0][1:-1], (q[0][2:] - q[0][:-2]) / 0.002, atol=2e-2)


def in_motion(tmp_path, noise_rad=0.0):
    """The second half of a swing, which begins at full speed, without measured velocity."""
    whole = measured(recording(pendulum(tmp_path), swing(), duration_s=1.5))
    fastest = int(np.argmax(np.abs(np.diff(whole.q[:100, 0]))))
    later = slice(fastest, None)
    q = whole.q[later]
    q = q + noise_rad * np.random.default_rng(0).normal(size=q.shape)
    return dataclasses.replace(whole, time=whole.time[later], q_des=whole.q_des[later], q=q)


def test_a_recording_that_starts_in_motion_is_started_in_motion(tmp_path):
    made = in_motion(tmp_path)
    slope = (made.q[1, 0] - made.q[0, 0]) / 0.01
    assert abs(slope) > 0.5
    assert start_state(made)[1] == pytest.approx([slope], rel=0.2)
    assert np.sqrt(np.mean((predict(made) - made.q[:, 0]) ** 2)) < 1e-3


def test_encoder_noise_does_not_set_a_resting_arm_in_motion(tmp_path):
    made = recording(pendulum(tmp_path), hold(0.0))
    noise = 1e-4 * np.random.default_rng(1).normal(size=made.q.shape)
    assert start_state(dataclasses.replace(made, q=noise))[1] == pytest.approx([0.0], abs=0.02)


def test_an_arm_that_is_measured_late_starts_where_its_commands_began(tmp_path):
    """The first position comes half a second after the first command: it is no start state."""
    whole = measured(recording(pendulum(tmp_path), swing(), duration_s=1.5))
    late = np.where(whole.time[:, None] < 0.5, np.nan, whole.q)
    made = dataclasses.replace(whole, q=late)
    error = predict(made) - whole.q[whole.time >= 0.5, 0]
    assert np.sqrt(np.mean(error**2)) < 5e-3


def test_a_model_on_some_joints_leaves_the_others_to_the_mjcf():
    robot = ROBOTS["two_joint_arm"]
    model = Model(str(robot.mjcf), {"coulomb_friction": {"torque": {"elbow": 0.2}}})
    layout, u = model.vector(robot.joints)
    assert [slot.joint for slot in layout.slots] == [1]
    assert u == pytest.approx([0.2])


def test_it_tells_how_far_it_is(tmp_path):
    made = [
        recording(pendulum(tmp_path), hold(0.1), duration_s=seconds, control_rate_hz=10_000.0)
        for seconds in (1.0, 2.0)
    ]
    told = []
    predictor = Predictor(made[0].robot, made, threads=1)
    quiet = predictor.predict([PLAIN])[0]
    np.testing.assert_array_equal(predictor.predict([PLAIN], progress=told.append)[0], quiet)
    assert len(told) > 5
    assert (np.diff(told) >= 0).all()
    assert 0.7 < told[-1] <= 1
