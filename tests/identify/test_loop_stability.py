import dataclasses
import re

import numpy as np
import pytest
import yaml

from t2l.errors import ConfigurationError
from t2l.identify.loop_stability import chattering, check_settles
from t2l.identify.model import Model
from t2l.identify.prediction import Predictor, Request
from tests.diagnose.made import LINK, pendulum, recording, two_pendulums

WITHOUT = 'damping="0"'  # nor armature, which a URDF cannot hold
LIGHT_KD = 4.27 * LINK * 1000  # at 1 kHz


def commands(time):
    return 0.3 * np.sin(3 * time)


@pytest.fixture
def robot(tmp_path):
    return pendulum(tmp_path, WITHOUT)


def with_armature(robot, **inertia):
    return Model(robot, {"armature": {"inertia": inertia}})


def diverges(model, log):
    layout, u = model.vector(log.joints)
    (q,) = Predictor(model.robot, [log]).predict([Request(layout, u[None])])
    return not (np.abs(q) < 1.0).all()


def test_a_loop_that_chatters_is_named_with_its_number(robot):
    log = recording(robot, commands, kd=LIGHT_KD)
    assert diverges(Model(robot), log)
    found = chattering(Model(robot), [log])
    assert found.joint == "hinge"
    assert found.inertia == pytest.approx(LINK)
    assert "Kd·h/M is 4.27 and must be below 2" in found.message
    assert "1/1000 s by control_rate_hz" in found.message
    with pytest.raises(ConfigurationError, match=r"joint hinge in made.*armature: \{inertia: "):
        check_settles(Model(robot), [log])


@pytest.mark.parametrize("factor", [0.3, 0.9, 1.9])
def test_a_loop_that_settles_is_not(robot, factor):
    log = recording(robot, commands, kd=factor * LINK * 1000)
    assert chattering(Model(robot), [log]) is None
    assert not diverges(Model(robot), log)


def test_the_line_of_yaml_is_the_least_that_settles(robot):
    log = recording(robot, commands, kd=LIGHT_KD)
    advice = chattering(Model(robot), [log]).advice
    effects = yaml.safe_load(re.search(r"effects: {.*}$", advice)[0])["effects"]
    inertia = effects["armature"]["inertia"]["hinge"]
    assert inertia == pytest.approx((4.27 / 2 - 1) * LINK, rel=0.06)  # of two digits
    model = Model(robot, effects)
    assert chattering(model, [log]) is None
    assert not diverges(model, log)
    assert chattering(with_armature(robot, hinge=0.9 * inertia), [log]) is not None


def test_too_little_of_it_is_told_with_what_it_must_be_in_all(robot):
    log = recording(robot, commands, kd=LIGHT_KD)
    whole = chattering(Model(robot), [log]).armature["hinge"]
    found = chattering(with_armature(robot, hinge=0.5 * whole), [log])
    assert found.armature["hinge"] == pytest.approx(whole, rel=0.1)


def test_every_joint_gets_some_so_that_it_is_fitted(tmp_path):
    robot = two_pendulums(tmp_path)
    log = recording(robot, lambda t: np.column_stack([commands(t)] * 2))
    assert chattering(Model(robot), [log]) is None
    # 1/h of the inertia that the plant has, armature included
    log = dataclasses.replace(log, kd=np.array([0.8, 100.0]))
    found = chattering(Model(robot), [log])
    assert found.joint == "right"
    # a fit is to find the armature of the other too
    assert found.armature["left"] == found.armature["right"]
    assert chattering(with_armature(robot, **found.armature), [log]) is None


def test_gains_that_the_model_corrects_are_those_that_count(robot):
    log = recording(robot, commands, kd=LIGHT_KD)
    right = Model(
        robot, {"controller_gains": {"kp_factor": {"hinge": 1}, "kd_factor": {"hinge": 0.2}}}
    )
    assert chattering(right, [log]) is None
    assert not diverges(right, log)


def test_of_a_loop_with_a_filter_nothing_is_claimed(robot):
    log = recording(robot, commands, kd=LIGHT_KD)
    model = Model(robot, {"velocity_filter": {"cutoff": 20.0}})
    assert chattering(model, [log]) is None


def test_stiffness_that_no_damping_holds_is_named_with_its_number(robot):
    kp = 3.0 * LINK * 1000**2
    found = chattering(Model(robot), [recording(robot, commands, kp=kp, kd=LINK * 1000)])
    assert "Kp·h²/M is 3 and must be below 2·Kd·h/M, which is 2" in found.message


def test_slow_swelling_is_not_chatter(robot):
    """Servos whose damping nobody knows have a Kd of 0; friction holds them."""
    assert chattering(Model(robot), [recording(robot, commands, kp=20.0, kd=0.0)]) is None


def test_poses_in_which_a_joint_is_light_count(tmp_path):
    """A link that hangs on across is heavy to shake, one that hangs on in line turns instead."""
    path = tmp_path / "folding.xml"
    path.write_text("""<mujoco><compiler angle="radian"/><worldbody><body pos="0 0 1">
      <joint name="left" axis="0 1 0"/>
      <inertial pos="0 0 0" mass="0.1" diaginertia="3e-3 3e-3 3e-3"/>
      <body pos="0 0 -0.3"><joint name="right" axis="0 1 0"/>
        <inertial pos="0 0 -0.3" mass="0.5" diaginertia="1e-3 1e-3 1e-3"/></body>
    </body></worldbody></mujoco>""")

    def fold(time):
        return np.column_stack([0 * time, 0.5 * np.pi * (1 + time / time[-1])])

    log = recording(str(path), fold, kp=1.0, duration_s=2.0, kd=10.0)
    log = dataclasses.replace(log, q=log.q_des, kd=np.array([10.0, 0.1]))
    assert chattering(Model(str(path)), [log]).joint == "left"
    start = dataclasses.replace(log, q=np.repeat(log.q[:1], len(log.q), axis=0))
    assert chattering(Model(str(path)), [start]) is None
