"""Along the motion that a model has itself it puts on the joints what the motion takes."""

import numpy as np
import pytest

from t2l.detective.linear_loop import linearised, respond
from t2l.detective.motion import mean_ddq, measured_motion
from t2l.detective.responses import _as_one
from t2l.effects.registry import builtin
from t2l.effects.term import Layout, Term
from t2l.identify.prediction import Predictor
from tests.diagnose.made import pendulum, recording, step, swing


@pytest.fixture(scope="module")
def robot(tmp_path_factory):
    return pendulum(tmp_path_factory.mktemp("robot"))


@pytest.mark.parametrize(
    ("name", "values"),
    [
        ("coulomb_friction", {"torque": 0.15}),
        ("viscous_friction", {"damping": 0.3}),
        ("parallel_spring", {"stiffness": 2.0, "rest": 0.3}),
        ("torque_speed_limit", {"stall_torque": 1.0, "no_load_speed": 3.0}),
    ],
)
def test_a_slow_loop_is_led_to_the_torque_that_moved_it(robot, name, values):
    recordings = [
        recording(robot, move, str(i), duration_s=2.0, control_rate_hz=100.0)
        for i, move in enumerate((swing(), step(0.5)))
    ]
    predictor = Predictor(robot, recordings, threads=1)
    layout, bare = Layout([Term(builtin()[name], (0,))]), (Layout(()), np.zeros(0))
    u = layout.encode({name: {key: np.array([value]) for key, value in values.items()}})
    (motion,) = measured_motion(predictor, *bare)
    ((group, q, dq),) = predictor.at_ticks(layout, u)
    motion.q[:], motion.dq[:], motion.ddq[:] = q, dq, mean_ddq(dq, group.schedule.period_s)
    (section,) = linearised(predictor, layout, u, [motion], bare)
    excess = _as_one(predictor, section, section.path, (layout, u))
    assert np.sqrt(np.mean(respond(section, excess[..., None]) ** 2)) < 5e-5
