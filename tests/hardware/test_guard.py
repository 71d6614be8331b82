import numpy as np

from t2l.hardware.guard import Guard, Workspace
from t2l.robots import make_robot
from tests.defaults import WORKSPACE

ROBOT = make_robot("fr3")


def test_what_must_not_be_sent_is_named():
    guard = Guard(ROBOT, 1, 0.02, Workspace(WORKSPACE.lower, (0.855, 0.855, 0.9)))
    q = ROBOT.home[None]
    still = np.zeros_like(q)
    assert guard.objections(q + 0.01, q, still) == [""]
    outside = q.copy()
    outside[0, 3] = 0.2
    assert "position command of fr3_joint4 0.2 rad" in guard.objections(outside, q, still)[0]
    assert "position of fr3_joint4 0.2 rad" in guard.objections(q, outside, still)[0]
    fast = still.copy()
    fast[0, 0] = 3.0
    assert "velocity of fr3_joint1 3 rad/s" in guard.objections(q, q, fast)[0]
    far = q.copy()
    far[0, 6] += 0.1
    # it asks for 12.8 N·m, which the controller clamps to 12
    assert guard.objections(far, q, still) == [""]
    up = np.zeros_like(q)
    up[0, [3, 5]] = -0.2, 1.6
    assert "measured z of the flange" in guard.objections(up, up, still)[0]


def test_soft_gains_may_command_far_ahead_of_the_arm():
    guard = Guard(ROBOT, 1, 0.01, WORKSPACE)
    q = ROBOT.home[None]
    down = q.copy()
    down[0, 1] += 1.7  # there the flange would be far below the table
    assert guard.objections(down, q, np.zeros_like(q)) == [""]
