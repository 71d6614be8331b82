"""First guesses that are read off what a model lacks."""

import numpy as np
import pytest

from t2l.effects.registry import builtin
from t2l.effects.term import Layout
from t2l.identify.prediction import Predictor
from tests.diagnose.made import measured, pendulum, read, recording, swing, two_pendulums


def test_a_ripple_is_read_off_on_each_joint_and_nothing_of_what_does_not_read(tmp_path):
    ripple = {"amplitude": 0.1, "phase": 0.7}
    periods = {"left": 27.0, "right": 40.0}
    planted = {name: dict.fromkeys(periods, value) for name, value in ripple.items()}

    def both(t):
        return np.stack([swing(0.5, 0.4)(t), swing(-0.4, 0.6)(t)], axis=1)

    plain = recording(two_pendulums(tmp_path), both, kp=80.0, kd=2.0, duration_s=4.0)
    made = measured(plain, {"cogging": planted | {"periods": periods}}, noise_rad=1e-5)
    predictor = Predictor(made.robot, [made], threads=1)
    effects = [builtin()["cogging"], builtin()["armature"]]
    found = read(predictor, (Layout(()), np.zeros(0)), effects)
    assert found["armature"] == []
    (guess,) = found["cogging"]
    assert guess["periods"] == pytest.approx([27.0, 40.0], rel=0.02)


def test_the_limits_of_a_motor_are_read_off(tmp_path):
    planted = {"stall_torque": {"hinge": 2.0}, "no_load_speed": {"hinge": 8.0}}
    plain = recording(pendulum(tmp_path), swing(0.8, 1.0), kp=10.0, kd=0.5, duration_s=3.0)
    made = measured(plain, {"torque_speed_limit": planted}, noise_rad=1e-4)
    predictor = Predictor(made.robot, [made], threads=1)
    effect = builtin()["torque_speed_limit"]
    (guess,) = read(predictor, (Layout(()), np.zeros(0)), [effect])[effect.name]
    # much nearer than the other first guesses are to each other
    assert guess["stall_torque"] == pytest.approx([2.0], rel=0.3)
    assert guess["no_load_speed"] == pytest.approx([8.0], rel=0.3)
