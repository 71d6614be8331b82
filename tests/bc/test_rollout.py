import numpy as np
import pandas as pd
import pytest

from t2l.actions import make_control
from t2l.bc.rollout import COLUMNS, TRACE_COLUMNS, pick_traces, roll_out, traces
from t2l.demos.retarget import hold, retarget
from t2l.gains import Cell
from t2l.tasks import make_task

CELL = Cell(128, 8)
CHUNK = 10


def control(task, kind="joint_target", **section):
    return make_control({"kind": kind, **section}, CELL, task.robot, task.model)


@pytest.fixture(scope="module")
def starts(demonstrations):
    return np.stack([d.qpos[0] for d in demonstrations[:4]])


class Recorded:
    """A policy that answers with the commands of retargeted demonstrations, chunk by chunk."""

    def __init__(self, task, demonstrations):
        controller = control(task).controller
        self.commands = [
            np.concatenate(
                [
                    hold(retarget(d, controller), CHUNK, "mean", controller),
                    d.gripper[:-1:CHUNK],
                ],
                axis=1,
            )
            for d in demonstrations
        ]
        self.asked = 0

    def __call__(self, history):
        at = self.asked * CHUNK + np.arange(CHUNK)
        self.asked += 1
        return np.stack([c[np.minimum(at, len(c) - 1)] for c in self.commands])


def constantly(action):
    return lambda history: np.tile(action, (len(history), CHUNK, 1))


def test_commands_that_solve_the_task_are_successes(task, demonstrations, starts):
    # an even number succeeds at different times, so freeze none before all have
    act = Recorded(task, demonstrations[:1])
    rollouts = roll_out(task, act, 10, CHUNK, control(task), starts[:1], decimation=10)
    table = rollouts.table
    assert tuple(table.columns) == COLUMNS
    assert table.success.all()
    assert table.failure.tolist() == [""]
    length_s = len(demonstrations[0]) * 0.002
    assert 0.8 * length_s < table.time_to_success_s[0] <= length_s


def test_standing_still_is_a_failure_and_not_a_divergence(task, starts):
    still = np.append(starts[0][task.arm_qpos], 0.04)
    rollouts = roll_out(
        task,
        constantly(still),
        10,
        CHUNK,
        control(task),
        starts,
        10,
        threads=2,
    )
    assert set(rollouts.table.failure) == {"not_grasped"}
    assert rollouts.table.time_to_success_s.isna().all()


def test_a_policy_that_answers_nan_has_diverged(task, starts):
    def act(history):
        chunk = np.tile(np.append(starts[0][task.arm_qpos], 0.04), (len(history), CHUNK, 1))
        chunk[0] = np.nan
        return chunk

    short = roll_out(task, act, 10, CHUNK, control(task), starts, 10)
    # the first of those still asked answers NaN, until none is left
    assert set(short.table.failure) == {"diverged"}
    assert not short.table.success.any()
    assert np.isfinite(short.qpos).all()


def test_a_simulation_that_blows_up_is_recorded_and_the_others_go_on(task, starts):
    def act(history):
        chunk = np.tile(np.append(starts[0][task.arm_qpos], 0.04), (len(history), CHUNK, 1))
        if len(history) == len(starts):
            chunk[1, :, 0] = 1e300
        return chunk

    table = roll_out(task, act, 10, CHUNK, control(task), starts, 10).table
    assert table.failure[1] == "diverged"
    assert set(table.failure.drop(1)) == {"not_grasped"}


def test_traces_hold_a_success_and_a_failure_of_each_kind(
    task, demonstrations, starts, block_stack
):
    act = Recorded(task, demonstrations[:1])
    good = traces(roll_out(task, act, 10, CHUNK, control(task), starts[:1], decimation=10), 10)
    still = np.append(starts[0][task.arm_qpos], 0.04)
    short = make_task({**block_stack, "horizon_s": 0.4})
    bad = traces(
        roll_out(
            short,
            constantly(still),
            10,
            CHUNK,
            control(short),
            starts,
            10,
        ),
        10,
    )
    assert tuple(good.columns) == TRACE_COLUMNS
    assert len(bad) == 21
    picked = pick_traces([("kp128_kd8", bad), ("kp64_kd8", good)], preferred="kp128_kd8")
    assert [label.split("\n")[0] for label in picked] == ["success", "failure"]
    times, qpos = picked["failure\nnot grasped\nKp 128, Kd 8"]
    assert qpos.shape == (21, task.model.nq)
    assert times[-1] == pytest.approx(0.4)
    other = bad.assign(failure="dropped")
    # two policies of a cell: what the first does not show, the second does, and that alone
    seeds = [("kp64_kd8", bad), ("kp128_kd8", bad), ("kp64_kd8", pd.concat([bad, other]))]
    picked = pick_traces(seeds, "kp128_kd8")
    assert list(picked) == ["failure\ndropped\nKp 64, Kd 8", "failure\nnot grasped\nKp 128, Kd 8"]
    assert len(picked["failure\ndropped\nKp 64, Kd 8"][0]) == 21
