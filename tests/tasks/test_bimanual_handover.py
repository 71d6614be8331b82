import numpy as np
import pytest
import yaml

from t2l.actions import make_control
from t2l.demos.expert import attempt
from t2l.demos.replay import replay
from t2l.gains import Cell
from t2l.sim import apply_position_gains, make_batch
from t2l.tasks import make_task
from tests.conftest import ROOT

SHIPPED = yaml.safe_load((ROOT / "config/tasks/bimanual_handover.yaml").read_text())


@pytest.fixture(scope="module")
def task():
    return make_task(SHIPPED)


@pytest.fixture(scope="module")
def attempts(task):
    rng = np.random.default_rng(0)
    return attempt(task, task.sample_starts(rng, 10), rng, threads=2)


def test_starts_are_where_the_file_says_and_differ(task):
    starts = task.sample_starts(np.random.default_rng(3), 300)
    x, y, _, w, *_, z = starts[:, task.bar_qpos].T
    yaw = SHIPPED["bar_yaw_rad"]
    ranges = SHIPPED["bar_x_m"], SHIPPED["bar_y_m"], [-yaw, yaw]
    for values, (low, high) in zip((x, y, 2 * np.arctan2(z, w)), ranges, strict=True):
        assert low <= values.min() < low + 0.1 * (high - low)
        assert high >= values.max() > high - 0.1 * (high - low)
    spread = starts[:, task.arm_qpos].std(axis=0)
    np.testing.assert_allclose(spread, SHIPPED["start_spread_rad"], rtol=0.2)


def test_nothing_moves_at_a_start(task):
    starts = task.sample_starts(np.random.default_rng(3), 10)
    batch = make_batch(task.model, 10)
    apply_position_gains(batch, task.robot.joints, 512.0, 24.0)
    task.reset(batch, starts)
    batch.step(nstep=250)
    np.testing.assert_allclose(batch.qpos, starts, atol=2e-3)


def test_observations_hold_both_hands_and_the_bar(task):
    batch, starts = make_batch(task.model, 3), task.sample_starts(np.random.default_rng(3), 3)
    task.reset(batch, starts)
    names = task.observation_names
    assert len(set(names)) == len(names)
    seen = dict(zip(names, task.observe(batch).T, strict=True))
    assert [name for name in names if name.startswith("q.")] == list(names[:14])
    np.testing.assert_array_equal(seen["q.right/fr3_joint2"], starts[:, task.arm_qpos[8]])
    np.testing.assert_allclose(seen["right/finger"], 0.04)
    # each hand on its own side
    assert (seen["left/grip.x"] < 0).all()
    assert (seen["right/grip.x"] > 0).all()
    for c in "xyz":
        for arm in ("left", "right"):
            apart = seen[f"bar.{c}"] - seen[f"{arm}/grip.{c}"]
            np.testing.assert_allclose(seen[f"bar_from_{arm}/grip.{c}"], apart, atol=1e-12)
    own = names[: task.robot_observation_size]
    assert not any("bar" in name for name in own)
    assert all("bar" in name for name in names[len(own) :])


def test_an_expert_hands_it_over(task, attempts):
    demonstrations, success = attempts
    assert success.mean() >= 0.9
    torque = np.max([np.abs(d.torque).max(axis=0) for d in demonstrations], axis=0)
    # no arm pulls against the other, or the table
    assert (torque < 0.6 * task.robot.torque_limit).all()


@pytest.mark.parametrize("cell", [Cell(16, 2), Cell(512, 24)], ids=lambda cell: cell.name)
def test_at_500_hz_a_replay_reproduces_both_arms(task, attempts, cell):
    control = make_control({"kind": "joint_target"}, cell, task.robot, task.model)
    replays = replay(task, attempts[0][:2], control, decimation=1, threads=2)
    assert all(r.success for r in replays)
    assert max(r.mse_q_rad2 for r in replays) < 1e-11


def test_without_contact_and_friction_a_replay_is_exact_to_rounding():
    free = make_task(SHIPPED)
    free.model.dof_frictionloss[:] = 0
    free.model.geom_contype[:] = free.model.geom_conaffinity[:] = 0
    rng = np.random.default_rng(0)
    demonstrations, _ = attempt(free, free.sample_starts(rng, 1), rng)
    control = make_control({"kind": "joint_target"}, Cell(128, 8), free.robot, free.model)
    (replayed,) = replay(free, demonstrations, control, decimation=1)
    assert replayed.mse_q_rad2 < 1e-24


@pytest.mark.parametrize(
    ("kind", "cell", "size"),
    [("joint_target", Cell(128, 8), 7), ("task_delta", Cell(1600, 80), 6)],
)
def test_at_50_hz_it_is_handed_over_too(task, attempts, kind, cell, size):
    control = make_control({"kind": kind}, cell, task.robot, task.model)
    replays = replay(task, attempts[0][:2], control, decimation=10, how="sample", threads=2)
    assert all(r.success for r in replays)
    observation, action = replays[0].episode
    # of both arms, and two grippers
    assert action.shape == (len(observation), 2 * size + 2)


@pytest.fixture(scope="module")
def moments(attempts):
    """Positions of a demonstration: on the table, carried, in both hands, in the second alone."""
    qpos = attempts[0][0].qpos
    shares = {"table": 0.0, "first": 0.58, "both": 0.76, "second": 1.0}
    return {name: qpos[round(share * (len(qpos) - 1))] for name, share in shares.items()}


@pytest.mark.parametrize(
    ("course", "kind"),
    [
        (["table"] * 9, "not_grasped"),
        (["first", "table"], "dropped"),
        (["first"] * 9, "not_handed_over"),
        (["first", *["both"] * 9], "not_released"),
        (["first", "both", *["second"] * 5], "not_held"),
        (["first", "both", *["second"] * 6], ""),
        (["second"] * 4 + ["both"] + ["second"] * 4, "not_held"),
        (["first", "both", *["second"] * 5, "table"], "dropped"),
    ],
)
def test_how_it_went_is_named(task, moments, course, kind):
    monitor, running = task.monitor(2), np.array([True, False])
    batch = make_batch(task.model, 2)
    for k, moment in enumerate(course):
        task.reset(batch, np.tile(moments[moment], (2, 1)))
        monitor.update(batch, 0.1 * (k + 1), running)
    assert monitor.failures(running) == [kind, "diverged"]
    assert np.isnan(monitor.success_time_s[0]) == bool(kind)


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        ({"bar_width_m": 0.08}, "bar_width_m: found 0.08; allowed: up to 0.07, which the gripper"),
        ({"robot": "fr3_hand"}, "robot: found fr3_hand, a robot of 1 arm with a gripper"),
        ({"robot": "fr3"}, "robot: found fr3, a robot of 0 arms with a gripper; allowed: of 2"),
        ({"bar_x_m": [0.1, -0.1]}, r"bar_x_m: found \[0.1, -0.1\]; allowed: low below high"),
        ({"bar_y_m": [0.1, 0.1]}, r"bar_y_m: found \[0.1, 0.1\]; allowed: low below high"),
    ],
)
def test_what_cannot_be_handed_over_is_refused(keys, message):
    with pytest.raises(ValueError, match=message):
        make_task({**SHIPPED, **keys})


def test_a_task_of_one_arm_refuses_two(block_stack):
    with pytest.raises(ValueError, match=r"found fr3_duo, a robot of 2 arms .* allowed: of 1"):
        make_task({**block_stack, "robot": "fr3_duo"})
