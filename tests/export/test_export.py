"""MuJoCo, stepping what was exported alone, moves as t2l predicts."""

import dataclasses
import json
import subprocess
import sys

import mujoco
import numpy as np
import pytest

from t2l.effects.registry import builtin
from t2l.errors import EffectError
from t2l.export.agreement import difference
from t2l.export.folder import write_export
from t2l.export.mjcf import Controller
from t2l.identify.initial_state import start_state
from t2l.identify.model import Model
from t2l.identify.refit import refit
from t2l.sim import servo
from t2l.sim.servo import ServoLoop
from tests.diagnose.made import (
    ARMATURE,
    DAMPING,
    measured,
    pendulum,
    recording,
    swing,
    two_pendulums,
)
from tests.effects.test_registry import RUBBER

# each large enough to show, for a pendulum of 1.2 N·m
VALUES = {
    "actuator_bandwidth": {"cutoff": 8.0},
    "armature": {"inertia": 0.02},
    "backlash": {
        "play": 0.03,
        "contact_time": 0.008,
        "contact_damping": 0.3,
        "encoder_on_link": 0.0,
    },
    "base_tilt": {"roll": 0.1, "pitch": 0.15},
    "clock_offset": {"offset": -0.0134},
    "cogging": {"amplitude": 0.2, "phase": 0.7, "periods": 12.0},
    "command_delay": {"delay": 0.0132},
    "command_filter": {"cutoff": 4.0},
    "controller_gains": {"kp_factor": 0.7, "kd_factor": 1.3},
    "coulomb_friction": {"torque": 0.1},
    "dahl_friction": {"coulomb": 0.1, "presliding": 0.02},
    "directional_friction": {"forward": 0.1, "backward": 0.04},
    "encoder_offset": {"offset": 0.1},
    "error_clip": {"limit": 0.03},
    "error_dead_band": {"band": 0.01},
    "free_running_torque": {"amplitude": 0.1, "frequency": 1.7},
    "friction_drift": {"at_start": 0.1, "at_end": 0.03, "time_constant": 0.5},
    "gravity_compensation_error": {"factor": 0.8},
    "integral_action": {"gain": 60.0, "limit": 0.6},
    "joint_flexibility": {"stiffness": 150.0, "damping": 0.2, "encoder_on_link": 0.0},
    "maxwell_slip_friction": {
        "torque_1": 0.04,
        "radius_1": 0.01,
        "torque_2": 0.03,
        "radius_2": 0.05,
        "torque_3": 0.05,
        "radius_3": 0.3,
    },
    "link_inertia": {
        "mass_factor": 1.2,
        "com_x": 0.01,
        "com_y": 0.0,
        "com_z": 0.02,
        "inertia_factor": 1.5,
    },
    "load_dependent_friction": {"motor": 0.05, "load": 0.03},
    "low_rate_loop": {"rate": 60.0, "phase": 0.0},
    "lugre_friction": {
        "coulomb": 0.08,
        "extra_at_rest": 0.06,
        "velocity": 0.3,
        "presliding": 0.02,
        "damping": 0.05,
    },
    "measurement_delay": {"delay": 0.0052},
    "parallel_spring": {"stiffness": 0.8, "rest": 0.5},
    "payload": {"mass": 0.2, "com_x": 0.01, "com_y": 0.0, "com_z": -0.02},
    "periodic_torque": {"amplitude": 0.1, "frequency": 1.7, "phase": 0.4},
    "quadratic_friction": {"coefficient": 0.1},
    "set_point_interpolation": {"ramp": 0.0304},
    "set_point_profile": {"velocity": 1.5, "acceleration": 30.0},
    "square_root_friction": {"coefficient": 0.1},
    "stribeck_friction": {"coulomb": 0.05, "extra_at_rest": 0.1, "velocity": 0.1},
    "torque_constant": {"factor": 0.8},
    "torque_constant_drift": {"at_start": 1.0, "at_end": 0.7, "time_constant": 0.5},
    "supply_sag": {"drop": 0.2},
    "torque_dead_zone": {"zone": 0.1},
    "torque_delay": {"delay": 0.0052},
    "torque_offset": {"torque": 0.3},
    "torque_rate_limit": {"rate": 100.0, "ramp": 0.6},
    "torque_ripple_with_position": {"amplitude": 0.2, "phase": 0.7, "periods": 12.0},
    "torque_saturation": {"limit": 1.0},
    "torque_speed_limit": {"stall_torque": 1.5, "no_load_speed": 6.0},
    "velocity_feed_forward": {"factor": 0.5},
    "velocity_filter": {"cutoff": 2.0},
    "viscous_friction": {"damping": 0.2},
}


def effect_of(name, joint="hinge", **changes):
    values = VALUES[name] | changes
    return {
        name: {
            p.name: {joint: values[p.name]} if p.per_joint else values[p.name]
            for p in builtin()[name].parameters
        }
    }


CASES = [(name, False) for name in VALUES if name != "gravity_compensation_error"]
# where MuJoCo's own compensation is not all
CASES += [
    (name, True)
    for name in (
        "base_tilt", "gravity_compensation_error", "integral_action", "link_inertia",
        "low_rate_loop", "payload", "torque_constant", "torque_rate_limit", "torque_saturation",
    )
]  # fmt: skip


def exported(
    folder, robot, effects, gravity_compensation=False, found=None, files=(), learned=(),
    commands=None, formulas=(), rate_hz=1000.0,
):  # fmt: skip
    log = recording(
        robot, commands or swing(0.5, 0.8), kp=20.0, kd=0.8, duration_s=1.5,
        gravity_compensation=gravity_compensation, control_rate_hz=rate_hz,
    )  # fmt: skip
    model = Model(robot, effects, files, learned, formulas=formulas)
    controller = Controller(log.joints, log.kp, log.kd, log.control_rate_hz, gravity_compensation)
    layout, u = model.vector(log.joints)
    folder.mkdir(exist_ok=True)
    content = write_export(model, controller, layout, u, found, folder)
    return content, difference(folder, model, layout, u, [log]), log


@pytest.fixture(scope="module")
def robot(tmp_path_factory):
    return pendulum(tmp_path_factory.mktemp("robot"))


@pytest.fixture
def first_order(monkeypatch):
    """Let ours take velocities and dampers where MuJoCo's own step does."""
    monkeypatch.setattr(ServoLoop, "_faster", lambda *_: lambda dq, _: np.zeros_like(dq))
    monkeypatch.setattr(ServoLoop, "_center_damping", lambda _: None)


# MuJoCo compensates gravity where its leading position is, half a period after the loop's tick
@pytest.mark.parametrize(("held", "most"), [(False, 1e-8), (True, 1e-4)])
def test_without_effects_it_is_the_same_motion(robot, tmp_path, first_order, held, most):
    assert exported(tmp_path / "out", robot, {}, held)[1] < most


def test_what_its_step_is_less_exact_by_falls_with_the_period(robot, tmp_path):
    """MuJoCo's own step is of first order, ours of second."""
    slow, fast = (
        exported(tmp_path / f"{rate:g}", robot, {}, rate_hz=rate)[1] for rate in (500.0, 1000.0)
    )
    assert fast < 2e-5
    assert slow == pytest.approx(2 * fast, rel=0.3)


def test_a_log_that_begins_in_motion_is_replayed_from_the_velocity_that_we_estimate(
    robot, tmp_path, first_order
):
    log = recording(robot, swing(0.5, 0.8), kp=20.0, kd=0.8, duration_s=1.5, row_rate_hz=200.0)
    exported(tmp_path / "out", robot, {})
    log = measured(log, {}, 1e-4)
    part = {"time": log.time[80:] - log.time[80], "q": log.q[80:], "q_des": log.q_des[80:]}
    log = dataclasses.replace(log, **part)
    assert abs(start_state(log)[1][0]) > 0.5
    layout, u = Model(robot).vector(log.joints)
    assert difference(tmp_path / "out", Model(robot), layout, u, [log]) < 1e-6


@pytest.mark.parametrize(("name", "held"), CASES)
def test_each_effect_moves_the_exported_robot_as_it_moves_ours(robot, tmp_path, name, held):
    content, error, log = exported(tmp_path / "out", robot, effect_of(name), held)
    moved = np.sqrt(np.mean((measured(log, effect_of(name)).q - measured(log).q) ** 2))
    assert not content["not_carried"]
    assert error < max(0.01 * moved, 1e-4 if held else 3e-5)


@pytest.mark.parametrize("held", [False, True])
@pytest.mark.parametrize("link", [0.0, 1.0])
@pytest.mark.parametrize("name", ["backlash", "joint_flexibility"])
def test_a_far_side_moves_as_ours_at_the_same_physics_step(
    robot, tmp_path, monkeypatch, first_order, name, link, held
):
    monkeypatch.setattr(servo, "EXTENDED", 1)
    content, error, _ = exported(
        tmp_path / "out", robot, effect_of(name, encoder_on_link=link), held
    )
    assert content["by_callback" if link else "in_mjcf"] == [name]
    assert error < (1e-4 if held else 1e-8)


MANY = (
    "integral_action", "velocity_filter", "low_rate_loop", "torque_rate_limit",
    "torque_saturation", "actuator_bandwidth", "torque_constant", "torque_offset",
    "lugre_friction", "encoder_offset", "command_delay",
)  # fmt: skip


@pytest.mark.parametrize("held", [False, True])
def test_effects_on_one_signal_act_in_their_order(tmp_path, first_order, held):
    joint = f'armature="{ARMATURE}" damping="{DAMPING}" actuatorfrcrange="-0.9 0.9"'
    robot = pendulum(tmp_path, joint)
    effects = {name: value for one in MANY for name, value in effect_of(one).items()}
    content, error, log = exported(tmp_path / "out", robot, effects, held)
    moved = np.sqrt(np.mean((measured(log, effects).q - measured(log).q) ** 2))
    assert sorted(content["in_mjcf"]) == ["command_delay", "encoder_offset", "torque_offset"]
    assert error < (0.01 * moved if held else 1e-8)


def test_an_effect_on_one_joint_leaves_the_other_alone(tmp_path):
    robot = two_pendulums(tmp_path)
    effects = {**effect_of("link_inertia", "right"), **effect_of("integral_action", "right")}
    effects |= effect_of("torque_rate_limit", "right")
    errors = {}
    for held in (False, True):
        log = recording(
            robot, lambda t: np.stack([swing(0.5, 0.9)(t), swing(-0.4, 1.3)(t)], axis=1),
            kp=20.0, kd=0.8, gravity_compensation=held,
        )  # fmt: skip
        model = Model(robot, effects)
        controller = Controller(log.joints, log.kp, log.kd, log.control_rate_hz, held)
        layout, u = model.vector(log.joints)
        (tmp_path / f"{held}").mkdir()
        content = write_export(model, controller, layout, u, None, tmp_path / f"{held}")
        assert ("link_inertia" in content["by_callback"]) == held
        errors[held] = difference(tmp_path / f"{held}", model, layout, u, [log])
    assert errors[False] < 3e-5
    assert errors[True] < 1e-4


def test_what_mjcf_holds_stays_there_until_a_callback_comes_before_it(tmp_path):
    robot = pendulum(tmp_path, 'armature="0.01" actuatorfrcrange="-0.9 0.9"')
    after = {**effect_of("torque_saturation"), **effect_of("torque_offset")}
    content, error, _ = exported(tmp_path / "after", robot, after)
    assert content["by_callback"] == []
    # the limit is the motor's, and the offset the joint's
    model = mujoco.MjModel.from_xml_path(str(tmp_path / "after/model.xml"))
    np.testing.assert_allclose(model.jnt_actfrcrange, [[-0.9 + 0.3, 0.9 + 0.3]])
    assert error < 3e-5
    before = {**after, **effect_of("torque_rate_limit")}
    content, error, _ = exported(tmp_path / "before", robot, before)
    assert content["by_callback"] == ["torque_rate_limit", "torque_saturation"]
    model = mujoco.MjModel.from_xml_path(str(tmp_path / "before/model.xml"))
    assert not model.jnt_actfrclimited.any()
    assert error < 3e-5


ALONE = """
import sys
sys.path.insert(0, "out")
for name in ("t2l", "scipy", "pydantic"):
    sys.modules[name] = None
import numpy as np
from robot import Robot
robot = Robot()
runs = []
for _ in range(2):
    robot.start([0.2], [0.0], [0.3])
    runs.append([robot.q.copy() for _ in range(200) if robot.step([0.3]) is None])
assert np.array_equal(*runs), "a second start differs"
print(float(runs[0][-1][0]))
"""


def test_it_runs_without_t2l_and_starts_anew(robot, tmp_path):
    effects = {name: value for one in MANY for name, value in effect_of(one).items()}
    exported(tmp_path / "out", robot, effects)
    run = subprocess.run(
        [sys.executable, "-c", ALONE], cwd=tmp_path, capture_output=True, text=True, check=False
    )
    assert run.returncode == 0, run.stderr
    assert abs(float(run.stdout) - 0.2) > 1e-3


def test_a_clock_offset_is_of_the_log(robot, tmp_path):
    content, _, _ = exported(tmp_path / "out", robot, effect_of("clock_offset"))
    assert (content["of_the_log"], content["log_lead_s"]) == (["clock_offset"], 0.0134)
    assert content["in_mjcf"] == content["by_callback"] == []
    exported(tmp_path / "without", robot, {})
    for name in ("model.xml", "robot.py", "robot.json"):
        texts = [(tmp_path / folder / name).read_text() for folder in ("out", "without")]
        assert texts[0] == texts[1]


def test_a_cable_and_friction_beside_the_mjcfs_own_are_tendons(tmp_path):
    robot = two_pendulums(tmp_path)
    both = {"left": 0.0, "right": 1.0}
    effects = {
        "coulomb_friction": {"torque": {"left": 0.05, "right": 0.0}},
        "joint_coupling": {
            key: {joint: size * value for joint, size in both.items()}
            for key, value in
            {"stiffness": 0.6, "damping": 0.02, "ratio": 0.7, "rest": 0.3, "before": 1.0}.items()
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


def test_what_cannot_be_carried_is_said(robot, tmp_path):
    warm = {"friction_temperature": {"torque": {"hinge": 0.1}, "per_kelvin": {"hinge": 0.0}}}
    model = Model(robot, {**warm, **effect_of("armature")})
    layout, u = model.vector(("hinge",))
    controller = Controller(("hinge",), np.array([20.0]), np.array([0.8]), 1000.0, False)
    content = write_export(model, controller, layout, u, None, tmp_path)
    assert list(content["not_carried"]) == ["friction_temperature"]
    assert content["in_mjcf"] == ["armature"]


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


HELPED = OWN.replace("class Rubber", "PULL = 1.0\n\n\nclass Rubber").replace(
    "robot.torque[joints] -= values", "robot.torque[joints] -= pull(robot) * values"
)
HELPER = """

def pull(robot):
    return {}
"""


def test_what_a_callback_uses_is_copied_with_it(robot, tmp_path):
    value = {"rubber": {"stiffness": {"hinge": 0.5}}}
    path = tmp_path / "rubber.py"
    path.write_text(HELPED + HELPER.format("PULL"))
    content, error, _ = exported(tmp_path / "out", robot, value, files=(path,))
    assert content["by_callback"] == ["rubber"]
    assert error < 2e-4
    path.write_text(HELPED + HELPER.format("PULL * abs(robot.angle[0]) + Rubber.order"))
    with pytest.raises(EffectError, match=r"rubber.*pull is to be exported, and uses Rubber"):
        exported(tmp_path / "class", robot, value, files=(path,))
    # a name that another effect has for something else
    other = value | effect_of("integral_action")
    path.write_text(
        HELPED.replace("pull(", "clamped(") + HELPER.format("1.0").replace("pull", "clamped")
    )
    with pytest.raises(EffectError, match=r"integral_action and rubber.*'clamped'"):
        exported(tmp_path / "twice", robot, other, files=(path,))


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
