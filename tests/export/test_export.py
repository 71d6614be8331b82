"""MuJoCo, stepping what was exported alone, moves as t2l predicts."""

import json

import numpy as np
import pytest

from t2l.effects.registry import builtin
from t2l.export.agreement import difference
from t2l.export.folder import write_export
from t2l.export.mjcf import Controller
from t2l.identify.model import Model
from t2l.identify.refit import refit
from tests.diagnose.made import measured, pendulum, recording, swing, two_pendulums
from tests.effects.test_registry import RUBBER

# each large enough to show, for a pendulum of 1.2 N·m
VALUES = {
    "armature": {"inertia": 0.02},
    "base_tilt": {"roll": 0.1, "pitch": 0.15},
    "cogging": {"amplitude": 0.2, "phase": 0.7, "periods": 12.0},
    "command_delay": {"delay": 0.0132},
    "command_filter": {"cutoff": 4.0},
    "controller_gains": {"kp_factor": 0.7, "kd_factor": 1.3},
    "coulomb_friction": {"torque": 0.1},
    "directional_friction": {"forward": 0.1, "backward": 0.04},
    "encoder_offset": {"offset": 0.1},
    "friction_drift": {"at_start": 0.1, "at_end": 0.03, "time_constant": 0.5},
    "joint_flexibility": {"stiffness": 60.0, "damping": 0.05, "encoder_on_link": 0.0},
    "link_inertia": {
        "mass_factor": 1.2,
        "com_x": 0.01,
        "com_y": 0.0,
        "com_z": 0.02,
        "inertia_factor": 1.5,
    },
    "load_dependent_friction": {"motor": 0.05, "load": 0.03},
    "parallel_spring": {"stiffness": 0.8, "rest": 0.5},
    "payload": {"mass": 0.2, "com_x": 0.01, "com_y": 0.0, "com_z": -0.02},
    "periodic_torque": {"amplitude": 0.1, "frequency": 1.7, "phase": 0.4},
    "quadratic_friction": {"coefficient": 0.1},
    "stribeck_friction": {"coulomb": 0.05, "extra_at_rest": 0.1, "velocity": 0.1},
    "torque_constant": {"factor": 0.8},
    "torque_constant_drift": {"at_start": 1.0, "at_end": 0.7, "time_constant": 0.5},
    "torque_offset": {"torque": 0.3},
    "torque_saturation": {"limit": 1.0},
    "torque_speed_limit": {"stall_torque": 1.5, "no_load_speed": 6.0},
    "viscous_friction": {"damping": 0.2},
}


def effect_of(name, joint="hinge"):
    return {
        name: {
            p.name: {joint: VALUES[name][p.name]} if p.per_joint else VALUES[name][p.name]
            for p in builtin()[name].parameters
        }
    }


def exported(folder, robot, effects, gravity_compensation=False, found=None, files=(), learned=()):
    log = recording(
        robot, swing(0.5, 0.8), kp=20.0, kd=0.8, duration_s=1.5,
        gravity_compensation=gravity_compensation,
    )  # fmt: skip
    model = Model(robot, effects, files, learned)
    controller = Controller(log.joints, log.kp, log.kd, log.control_rate_hz, gravity_compensation)
    layout, u = model.vector(log.joints)
    folder.mkdir(exist_ok=True)
    content = write_export(model, controller, layout, u, found, folder)
    return content, difference(folder, model, layout, u, [log]), log


@pytest.fixture(scope="module")
def robot(tmp_path_factory):
    return pendulum(tmp_path_factory.mktemp("robot"))


@pytest.fixture(scope="module")
def plain(robot, tmp_path_factory):
    """How far the exported robot is without effects, rad, by gravity compensation."""
    folder = tmp_path_factory.mktemp("plain")
    return {held: exported(folder / f"{held}", robot, {}, held)[1] for held in (False, True)}


def test_without_effects_it_is_the_same_motion(plain):
    assert plain[False] < 1e-6
    # MuJoCo compensates gravity where its leading position is, half a period after the loop's tick
    assert plain[True] < 1e-4


@pytest.mark.parametrize("name", VALUES)
def test_each_effect_moves_the_exported_robot_as_it_moves_ours(robot, plain, tmp_path, name):
    content, error, log = exported(tmp_path / "out", robot, effect_of(name))
    moved = np.sqrt(np.mean((measured(log, effect_of(name)).q - measured(log).q) ** 2))
    assert not content["not_carried"]
    assert error < max(0.01 * moved, 3e-5)


def test_a_cable_and_friction_beside_the_mjcfs_own_are_tendons(tmp_path):
    robot = two_pendulums(tmp_path)
    both = {"left": 0.0, "right": 1.0}
    effects = {
        "coulomb_friction": {"torque": {"left": 0.05, "right": 0.0}},
        "joint_coupling": {
            key: {joint: size * value for joint, size in both.items()}
            for key, value in
            {"stiffness": 0.6, "damping": 0.02, "ratio": 0.7, "rest": 0.3}.items()
        },
    }  # fmt: skip

    def swings(t):
        return np.stack([swing(0.5, 0.9)(t), swing(-0.4, 1.3)(t)], axis=1)

    log = recording(robot, swings, kp=20.0, kd=0.8, duration_s=1.0)
    model = Model(robot, effects)
    controller = Controller(log.joints, log.kp, log.kd, log.control_rate_hz, False)
    layout, u = model.vector(log.joints)
    (tmp_path / "out").mkdir()
    content = write_export(model, controller, layout, u, None, tmp_path / "out")
    assert sorted(content["in_mjcf"]) == ["coulomb_friction", "joint_coupling"]
    assert difference(tmp_path / "out", model, layout, u, [log]) < 1e-4


def test_gravity_compensation_of_a_weak_motor_is_weak_too(robot, tmp_path):
    _, error, _ = exported(tmp_path / "out", robot, effect_of("torque_constant"), True)
    assert error < 1e-4


def test_what_cannot_be_carried_is_said(robot, tmp_path):
    effects = {"low_rate_loop": {"rate": 100.0}, **effect_of("armature")}
    content, _, _ = exported(tmp_path / "out", robot, effects)
    assert list(content["not_carried"]) == ["low_rate_loop"]
    assert content["in_mjcf"] == ["armature"]
    assert "Not carried: low_rate_loop" in (tmp_path / "out/robot.py").read_text()


OWN = (
    RUBBER
    + """
    def export(self, to, joints, values):
        to.call(self.name, rubber, joints, values)


def rubber(robot, joints, values):
    robot.torque[joints] -= values["stiffness"] * robot.angle[joints]
"""
)


def test_an_effect_of_ones_own_is_not_carried_until_it_says_how(robot, tmp_path):
    (tmp_path / "rubber.py").write_text(RUBBER)
    value = {"rubber": {"stiffness": {"hinge": 0.5}}}
    files = (tmp_path / "rubber.py",)
    content, _, _ = exported(tmp_path / "out", robot, value, files=files)
    assert list(content["not_carried"]) == ["rubber"]
    (tmp_path / "own").mkdir()
    (tmp_path / "own/rubber.py").write_text(OWN)
    files = (tmp_path / "own/rubber.py",)
    content, error, _ = exported(tmp_path / "out", robot, value, files=files)
    assert content["by_callback"] == ["rubber"]
    assert error < 2e-4  # t2l takes the angle at the beginning of a step, the callback halfway


def test_ranges_are_of_fields_that_mujoco_has(robot, tmp_path):
    effects = {**effect_of("armature"), **effect_of("cogging")}
    log = recording(robot, swing(0.5, 0.8), kp=20.0, kd=0.8, duration_s=1.5)
    model = Model(robot, effects)
    found = refit(model, [measured(log, effects, 1e-4)]).found
    content, _, _ = exported(tmp_path / "out", robot, effects, found=found)
    (armature,) = content["ranges"]["mjmodel"]
    assert (armature["field"], armature["name"]) == ("dof_armature", "hinge")
    low, high = armature["range"]
    assert low < 0.025 < high
    assert high - low < 0.01
    by_callback = [p for p in content["ranges"]["parameters"] if p["effect"] == "cogging"]
    assert all(p["range"][0] < p["value"] < p["range"][1] for p in by_callback)
    assert json.loads((tmp_path / "out/export.json").read_text()) == content
