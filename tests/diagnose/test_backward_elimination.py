import numpy as np
import pytest

from t2l.diagnose.backward_elimination import simplify
from t2l.diagnose.evidence import gather
from t2l.identify.model import Model
from tests.diagnose.made import measured, pendulum, recording, swing

VISCOUS = {"viscous_friction": {"damping": {"hinge": 0.05}}}


def evidence(robot, count):
    """Recordings of a pendulum with viscous friction; of more than twelve, some are shortlisted."""
    made = [
        measured(
            recording(robot, swing(0.5, 0.6 + 0.05 * i), f"r{i}", 5.0 + 3.0 * i, 0.4, 0.6),
            VISCOUS, 1e-4, seed=i,
        )
        for i in range(count)
    ]  # fmt: skip
    return gather(robot, made)


@pytest.mark.parametrize("count", [4, 20])
def test_what_a_later_effect_made_superfluous_is_taken_back(tmp_path, count):
    robot = pendulum(tmp_path)
    both = Model(robot, {"torque_offset": {"torque": {"hinge": 0.001}}, **VISCOUS})
    found, gone = simplify(both, evidence(robot, count))
    assert gone == ["torque_offset"]
    assert found.effects["viscous_friction"]["damping"]["hinge"] == pytest.approx(0.05, rel=0.03)


def test_what_is_needed_stays(tmp_path):
    robot = pendulum(tmp_path)
    model = Model(robot, VISCOUS)
    assert simplify(model, evidence(robot, 4)) == (model, [])


def test_an_effect_is_replaced_by_the_simpler_one_that_it_contains(tmp_path):
    robot = pendulum(tmp_path)
    dry = {"coulomb_friction": {"torque": {"hinge": 0.05}}}
    made = [
        measured(recording(robot, swing(0.5, 0.8), f"r{i}", kp, 0.4, 0.8), dry, 1e-4, seed=i)
        for i, kp in enumerate(np.geomspace(5, 60, 4))
    ]
    stribeck = {
        "stribeck_friction": {
            "coulomb": {"hinge": 0.05},
            "extra_at_rest": {"hinge": 0.0005},
            "velocity": {"hinge": 0.05},
        }
    }  # fmt: skip
    found, gone = simplify(Model(robot, stribeck), gather(robot, made))
    assert gone == ["stribeck_friction"]
    assert list(found.effects) == ["coulomb_friction"]
    assert found.effects["coulomb_friction"]["torque"]["hinge"] == pytest.approx(0.05, rel=0.1)
