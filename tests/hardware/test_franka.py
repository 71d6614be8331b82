"""A deployment to aiofranka's own simulated robot, in real time."""

import numpy as np
import pytest

from t2l.gains import Cell
from t2l.hardware import franka_arm as franka
from t2l.hardware.backend import BackendError
from t2l.hardware.franka import FrankaRobot
from t2l.tasks.reach import JointReach
from t2l.transfer.deploy import deploy
from tests.defaults import WORKSPACE
from tests.hardware.test_record import lose_connection
from tests.transfer.test_deploy import proportional

# where aiofranka's simulation begins
START = np.array([[0, 0, 0, -1.57079, 0, 1.57079, -0.7853]])


@pytest.fixture(autouse=True)
def _impatient(monkeypatch):
    monkeypatch.setattr(franka, "SETTLE_S", 0.3)


def test_a_policy_reaches_on_aiofrankas_robot_and_is_stopped_where_it_must(tmp_path):
    robot = FrankaRobot("simulation")
    task, cell = JointReach(), Cell(128, 16)
    starts, goals = START.repeat(2, axis=0), START.repeat(2, axis=0) + 0.1
    try:
        rollouts = deploy(
            robot, proportional(), task, cell, starts, goals, 50.0, 3.0, WORKSPACE, tmp_path
        )
        wild = proportional(gain=20.0, scale=(0.2, 1.5))
        stopped = deploy(robot, wild, task, cell, starts[:1], goals[:1] + 0.2, 50.0, 1.0, WORKSPACE)
    finally:
        robot.close()
    assert rollouts.success.all()
    assert rollouts.stopped == ("", "")
    # it moved, and rests at the end
    assert np.abs(rollouts.dq).max() > 0.05
    assert np.abs(rollouts.dq[-20:]).max() < 0.05
    assert "torque of fr3_joint" in stopped.stopped[0]
    with pytest.raises(BackendError):
        robot.step(START, 0.02)


def test_a_robot_that_is_not_there_is_named():
    with pytest.raises(BackendError, match=r"address: found 127.0.0.1, which cannot be reached"):
        FrankaRobot("127.0.0.1", "config: robot")


def test_a_lost_connection_loses_no_rollout_that_was_complete(tmp_path):
    starts, goals = START.repeat(2, axis=0), START.repeat(2, axis=0) + 0.05
    policy, calls = proportional(), iter(range(1000))
    act = policy.act

    def reached(robot, policy=policy):
        rollouts = deploy(
            robot,
            policy,
            JointReach(),
            Cell(128, 16),
            starts,
            goals,
            50.0,
            0.4,
            WORKSPACE,
            tmp_path,
        )
        robot.close()
        return rollouts

    lost = FrankaRobot("simulation")

    def loses(observation):
        # in the middle of the second rollout
        if next(calls) == 30:
            lose_connection(lost._arm.controller)
        return act(observation)

    object.__setattr__(policy, "act", loses)
    with pytest.raises(BackendError, match=r"control loop.* stopped.*UDP receive"):
        reached(lost)
    assert [kept.name for kept in tmp_path.iterdir()] == ["000.npz"]
    first = tmp_path / "000.npz"
    before = first.stat().st_mtime_ns
    rollouts = reached(FrankaRobot("simulation"), proportional())
    assert first.stat().st_mtime_ns == before
    assert rollouts.stopped == ("", "")
    assert np.isfinite(rollouts.q).all()
