import numpy as np
import pytest

from t2l.advise.machine import of_model
from t2l.identify.model import Model
from t2l.robots import make_robot
from tests.conftest import ROOT

ARM = str(ROOT / "examples/two_joint_arm/two_joint_arm.xml")
JOINTS = ("shoulder", "elbow")
POSES = np.array([[0.0, 0.0], [0.4, 0.7], [1.2, -0.9]])


def test_a_heavier_armature_is_all_of_a_joints_own():
    bare = of_model(Model(ARM), JOINTS, POSES, 1000.0, True)
    heavier = {"armature": {"inertia": {"shoulder": 0.02, "elbow": 0.05}}}
    more = of_model(Model(ARM, heavier), JOINTS, POSES, 1000.0, True)
    assert more.inertia - bare.inertia == pytest.approx(np.tile([0.02, 0.05], (3, 1)))


def test_the_weight_is_what_the_arm_asks_for_and_nothing_where_it_is_carried():
    hangs = of_model(Model(ARM), JOINTS, POSES, 1000.0, False)
    # at zero it hangs straight down; the forearm's centre is 0.15 m from its joint, 0.4 kg
    assert hangs.weight[0] == pytest.approx([0, 0], abs=1e-9)
    assert abs(hangs.weight[1, 1]) == pytest.approx(0.4 * 9.81 * 0.15 * np.sin(1.1), rel=1e-3)
    assert hangs.plant.stiffness[0, 1, 1] == pytest.approx(0.4 * 9.81 * 0.15, rel=1e-3)
    carried = of_model(Model(ARM), JOINTS, POSES, 1000.0, True)
    assert not carried.weight.any()
    assert not carried.plant.stiffness.any()


def test_signals_are_those_of_the_effects():
    effects = {
        "torque_delay": {"delay": 0.002},
        "measurement_delay": {"delay": 0.003},
        "command_delay": {"delay": 0.018},
        "low_rate_loop": {"rate": 250.0, "phase": 0.0},
        "actuator_bandwidth": {"cutoff": {"elbow": 40.0}},
        "backlash": {"half_width": {"elbow": 0.01}},
    }
    known = Model(ARM).known_effects(JOINTS)["backlash"].parameters
    effects["backlash"] = {p.name: {"elbow": 0.01} if p.per_joint else 0.0 for p in known}
    machine = of_model(Model(ARM, effects), JOINTS, POSES, 1000.0, True)
    assert machine.rate_hz == 250
    assert machine.signals.delay_s == pytest.approx([0.005, 0.005])
    assert machine.signals.command_delay_s == pytest.approx([0.015, 0.015])
    assert machine.signals.motor_hz.tolist() == [np.inf, 40.0]
    assert [title.lower() for title in machine.left_out] == ["backlash"]


def test_of_a_known_robot():
    robot = make_robot("fr3")
    machine = of_model(Model("fr3"), robot.joints, robot.home[None], 1000.0, True)
    assert machine.torque_limit == pytest.approx(robot.torque_limit)
    # a shoulder moves some tens of times what a wrist does
    assert 5 < machine.inertia[0, 0] / machine.inertia[0, 6] < 100
    alone = machine.alone(3)
    assert alone.mass.shape == (1, 1, 1)
    assert alone.mass[0, 0, 0] == machine.inertia[0, 3]


def test_names_with_a_slash_are_names_of_joints():
    robot = make_robot("fr3_duo")
    machine = of_model(Model("fr3_duo"), robot.joints, robot.home[None], 1000.0, True)
    assert machine.of_joint.tolist() == list(range(14))
    assert machine.inertia[0, :7] == pytest.approx(machine.inertia[0, 7:], rel=1e-3)
