import numpy as np
import pytest

from t2l.drift.artefacts import sentence
from t2l.drift.verdict import DRIFTED, UNCHANGED, UNTOLD, verdicts
from t2l.identify.model import Model
from t2l.identify.refit import refit
from tests.diagnose.made import measured, pendulum, recording, swing

ADOPTED = {
    "coulomb_friction": {"torque": {"hinge": 0.05}},
    "command_delay": {"delay": 0.012},
}


@pytest.fixture(scope="module")
def robot(tmp_path_factory):
    return pendulum(tmp_path_factory.mktemp("robot"))


def logs(robot, effects, seed=0, q_des=None):
    log = recording(robot, q_des or swing(0.5, 0.8), kp=20.0, kd=0.8, duration_s=2.0,
                    control_rate_hz=500.0)  # fmt: skip
    return [measured(log, effects, 1e-4, seed)]


def judge(robot, effects, seed=0, reference=None, **of):
    model = Model(robot, ADOPTED)
    new = refit(model, logs(robot, effects, seed, **of), hold_each=True)
    old = None if reference is None else refit(model, logs(robot, reference, seed + 100))
    return {one.effect: one for one in verdicts(new, ("hinge",), old)}, new


def test_only_the_effect_that_drifted_is_said_to_have(robot):
    worn = {**ADOPTED, "coulomb_friction": {"torque": {"hinge": 0.08}}}
    found, new = judge(robot, worn, reference=ADOPTED)
    assert found["coulomb_friction"].verdict == DRIFTED
    assert found["command_delay"].verdict == UNCHANGED
    (change,) = found["coulomb_friction"].changes
    assert change.interval[0] < 0.08 < change.interval[1]
    assert new.after < 0.5 * new.before
    assert "Drifted: coulomb_friction." in sentence(list(found.values()), new, 1e-4)


def test_a_machine_that_has_not_changed_is_not_accused(robot):
    for seed in range(3):
        found, _ = judge(robot, ADOPTED, seed, reference=ADOPTED)
        assert {one.verdict for one in found.values()} == {UNCHANGED}


def test_a_log_without_motion_tells_nothing_of_a_delay(robot):
    found, _ = judge(robot, ADOPTED, q_des=lambda t: np.full(len(t), 0.3))
    assert found["command_delay"].verdict == UNTOLD


def test_something_else_that_changed_is_not_hidden(robot):
    loaded = {**ADOPTED, "cogging": {"amplitude": {"hinge": 0.2}, "phase": {"hinge": 0.0},
                                     "periods": {"hinge": 30.0}}}  # fmt: skip
    found, new = judge(robot, loaded)
    assert "something else is missing" in sentence(list(found.values()), new, 1e-4)
