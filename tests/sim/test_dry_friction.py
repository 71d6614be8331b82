"""What an effect adds to dry friction, beside what the MJCF has already."""

import numpy as np
import pytest

from tests.diagnose.made import hold, pendulum, predict, recording, spinner, step, swing

OWN = 'armature="0.005" damping="0.02" frictionloss="0.05"'
KP = 20.0


def added(torque):
    return {"coulomb_friction": {"torque": {"hinge": torque}}}


@pytest.mark.parametrize("push", [0.12, -0.12])
def test_both_frictions_hold_a_joint_together(tmp_path, push):
    """The added one bears all that it can, and does not creep; the MJCF's own alone does."""
    made = recording(spinner(tmp_path, OWN), step(push / KP), kp=KP, duration_s=1.0)
    both = predict(made, added(0.1))
    assert np.abs(both).max() < 0.5 * abs(push) / KP
    assert abs(both[-1]) < abs(predict(made, added(0.02))[-1])


def test_added_friction_does_not_soften_with_a_smaller_step(tmp_path):
    made = recording(pendulum(tmp_path, OWN), swing(), kp=KP, duration_s=1.0)
    coarse, fine = (predict(made, added(0.05), substeps=n) for n in (1, 4))
    assert np.sqrt(np.mean((coarse - fine) ** 2)) < 3e-5


def test_friction_that_is_taken_away_leaves_none(tmp_path):
    bare = 'armature="0.005" damping="0.02"'
    found = [
        predict(recording(pendulum(tmp_path, joint), swing(), kp=KP, duration_s=0.5), effects)
        for joint, effects in ((OWN, added(-0.05)), (bare, {}))
    ]
    np.testing.assert_allclose(*found, atol=1e-9)


def test_added_friction_beside_no_other_is_the_joints_own(tmp_path):
    made = recording(spinner(tmp_path), hold(0.0), kp=KP, duration_s=0.3)
    assert np.abs(predict(made, added(0.05))).max() < 1e-9
