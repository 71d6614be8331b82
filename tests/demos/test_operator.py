"""What limits an operator does so, and nothing else does."""

import numpy as np
import pytest

from t2l.actions import make_control
from t2l.demos.operator import Operator, Person
from t2l.gains import Cell
from t2l.sim import make_batch

CENTRE = Cell(128, 8)
TICK_S = 0.02


def person(reaction_s=0.0, motor_noise=0.0):
    return Person(reaction_s, motor_noise, [2], 1)


def at_the_controls(task, who, n=2, crossover_rad_s=2.0, kind="joint_target", cell=CENTRE):
    """An operator, the batch and the controller."""
    control = make_control({"kind": kind}, cell, task.robot, task.model)
    rng = np.random.default_rng(3)
    batch, starts = make_batch(task.model, n), task.sample_starts(rng, n)
    control.controller.install(batch)
    task.reset(batch, starts)
    operator = Operator(task, control, batch, starts, TICK_S, who, crossover_rad_s, rng)
    return operator, batch, control.controller


@pytest.mark.parametrize(
    ("kind", "cell"),
    [("joint_target", CENTRE), ("task_pose", Cell(400, 40))],
    ids=["joint", "tool"],
)
def test_without_limits_the_hand_follows_the_waypoints(task, kind, cell):
    operator, batch, controller = at_the_controls(task, person(), kind=kind, cell=cell)
    running = np.ones(2, bool)
    missed = []
    # above the block, down to it
    for _ in range(90):
        command, gripper = operator.act(running)
        task.command_grippers(batch.ctrl, gripper)
        controller.step(batch, command, running, 10)
        missed.append(np.linalg.norm(operator.wanted[:, 0, :3] - task.grip(batch), axis=1))
    way = np.linalg.norm(task.grip(batch) - task.block_poses(batch.qpos)[:, 0, :3], axis=1)
    assert way.max() < 0.03
    # what friction keeps from the hand, of a way of 0.3 m
    assert np.max(missed) < 0.015


def test_what_happens_is_seen_after_the_reaction_time(task):
    def commands(pushed_at):
        operator, batch, _ = at_the_controls(task, person(reaction_s=0.2))
        sent = []
        for k in range(20):
            if k == pushed_at:
                batch.qpos[0, task.arm_qpos[0]] += 0.05
                batch.forward()
            # nothing moves, so that nothing else tells of the push
            sent.append(operator.act(np.ones(2, bool))[0])
        return np.array(sent)

    changed = (commands(4) != commands(None)).any(axis=2)
    assert np.flatnonzero(changed[:, 0])[0] == 4 + round(0.2 / TICK_S)
    assert not changed[:, 1].any()


def test_the_end_of_a_movement_scatters_by_the_motor_noise(task):
    noise = 0.03
    who = person(motor_noise=noise)
    operator, *_ = at_the_controls(task, who, n=200, crossover_rad_s=0.0)
    positions = [operator.wanted[:, 0, :3]]
    for _ in range(40):
        operator.act(np.ones(200, bool))
        positions.append(operator.wanted[:, 0, :3])
    # of a movement at a steady speed for 1 s: its length
    way = np.sqrt((np.diff(positions, axis=0) ** 2).sum(axis=(0, 2)) / TICK_S)
    scatter = (operator.meant[:, 0, :3] - positions[-1]) / way[:, None]
    assert scatter.std() == pytest.approx(noise, rel=0.2)


def test_who_has_ended_is_left_alone(task):
    operator, batch, _ = at_the_controls(task, person())
    batch.qpos[1] = np.nan
    for _ in range(5):
        command, _ = operator.act(np.array([True, False]))
    assert np.isfinite(command).all()
