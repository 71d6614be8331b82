import dataclasses

import numpy as np
import pytest

from t2l.identify.prediction import Predictor
from t2l.identify.scales import gravity_torque, scales
from tests.diagnose.made import (
    ARMATURE,
    DAMPING,
    INERTIA,
    WEIGHT,
    hold,
    measured,
    pendulum,
    recording,
    swing,
)


def test_scales_are_sizes_of_the_motion_and_the_plant(tmp_path):
    speed, kp = 2.0, 20.0
    robot = pendulum(tmp_path, f'armature="{ARMATURE}" damping="{DAMPING}" frictionloss="0.03"')
    made = recording(
        robot, lambda t: 0.3 * np.sin(speed * t), kp=kp, kd=0.1, duration_s=2 * np.pi / speed
    )
    sizes = scales(Predictor(robot, [measured(made)]))
    assert sizes.inertia == pytest.approx([INERTIA])
    assert sizes.velocity == pytest.approx([0.3 * speed / np.sqrt(2)], rel=0.2)
    assert sizes.range == pytest.approx([0.6], rel=0.2)
    assert sizes.peak_torque > sizes.torque
    assert sizes.armature == pytest.approx([ARMATURE])
    assert sizes.friction == pytest.approx([0.03])
    assert sizes.damping == pytest.approx([DAMPING])


def test_the_motor_torque_of_a_resting_arm_counts_its_weight_once(tmp_path):
    """Springs carry the weight, or compensation does, but never both."""
    at = 0.9
    made = recording(pendulum(tmp_path), hold(at), kp=30.0, kd=2.0, duration_s=2.0)
    weight = WEIGHT * np.sin(at)
    compensated = dataclasses.replace(made, gravity_compensation=True)
    held = scales(Predictor(made.robot, [measured(compensated)]))
    assert held.torque == pytest.approx([weight], rel=0.02)
    raised = dataclasses.replace(made, q_des=made.q_des + weight / 30.0)
    assert scales(Predictor(made.robot, [measured(raised)])).torque == pytest.approx(
        [weight], rel=0.02
    )


def test_gravity_is_that_of_the_measured_pose(tmp_path):
    made = recording(pendulum(tmp_path), swing(1.0), duration_s=1.0)
    made = dataclasses.replace(made, q=swing(1.0)(made.time)[:, None])
    np.testing.assert_allclose(
        gravity_torque(Predictor(made.robot, [made])), WEIGHT * np.sin(made.q[:, 0]), atol=1e-9
    )
