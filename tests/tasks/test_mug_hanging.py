import numpy as np
import pytest
import yaml

from t2l.demos.expert import attempt
from t2l.sim import apply_position_gains, make_batch
from t2l.tasks import make_task
from t2l.tasks.poses import upright
from tests.conftest import ROOT

SHIPPED = yaml.safe_load((ROOT / "config/tasks/mug_hanging.yaml").read_text())
PERIOD_S = 0.02


@pytest.fixture(scope="module")
def task():
    return make_task(SHIPPED)


def new_batch(task, n):
    batch = make_batch(task.model, n)
    apply_position_gains(batch, task.robot.joints, 512.0, 24.0)
    return batch


def mug_at(task, start, handles, yaw=0.0):
    """Positions (n, nq) as `start` (nq,), the mug upright with its handle at `handles` (n, 3)."""
    handles = np.atleast_2d(handles)
    qpos = np.tile(start, (len(handles), 1))
    c, s = np.cos(yaw), np.sin(yaw)
    offset = [[c, -s, 0], [s, c, 0], [0, 0, 1]] @ task.mug.handle
    qpos[:, task.pose_of("mug")] = upright(handles - offset, np.full(len(handles), yaw))
    return qpos


def along_peg(task, share):
    tip, root = task.tree.peg
    return tip + share * (root - tip)


@pytest.fixture(scope="module")
def start(task):
    return task.sample_starts(np.random.default_rng(3), 1)[0]


def test_starts_are_where_the_file_says_and_differ(task):
    poses = task.sample_starts(np.random.default_rng(3), 300)[:, task.pose_of("mug")]
    yaw = 2 * np.arctan2(poses[:, 6], poses[:, 3])
    turned = SHIPPED["mug_yaw_rad"]
    ranges = SHIPPED["mug_x_m"], SHIPPED["mug_y_m"], [-turned, turned]
    for values, (low, high) in zip((*poses[:, :2].T, yaw), ranges, strict=True):
        assert low <= values.min() < low + 0.1 * (high - low)
        assert high >= values.max() > high - 0.1 * (high - low)


def test_nothing_moves_at_a_start(task):
    starts = task.sample_starts(np.random.default_rng(3), 10)
    batch = new_batch(task, 10)
    task.reset(batch, starts)
    batch.step(nstep=250)
    np.testing.assert_allclose(batch.qpos, starts, atol=2e-3)


def test_a_batch_that_was_used_starts_like_a_new_one(task):
    starts = task.sample_starts(np.random.default_rng(3), 4)
    seen = []
    used = new_batch(task, 4)
    task.reset(used, starts[::-1])
    task.command(used.bind("ctrl"), task.robot.home + 0.3, 0.0)
    used.step(nstep=300)
    for batch in (used, new_batch(task, 4)):
        task.reset(batch, starts)
        before = task.observe(batch)
        batch.step(nstep=300)
        seen.append([before, batch.qpos.copy()])
    np.testing.assert_array_equal(seen[0][0], seen[1][0])
    np.testing.assert_array_equal(seen[0][1], seen[1][1])


def test_observations_are_what_their_names_say(task, start):
    tip = task.tree.peg[0]
    batch = new_batch(task, 2)
    task.reset(batch, mug_at(task, start, [tip - [0, 0.1, 0], tip - [0.2, 0, 0.05]], yaw=0.3))
    seen = dict(zip(task.observation_names, task.observe(batch).T, strict=True))
    own = task.observation_names[: task.robot_observation_size]
    assert not any("mug" in name or "handle" in name for name in own)
    np.testing.assert_allclose(seen["peg_from_handle.x"], [0, 0.2], atol=1e-9)
    np.testing.assert_allclose(seen["peg_from_handle.y"], [0.1, 0], atol=1e-9)
    np.testing.assert_allclose(seen["peg_from_handle.z"], [0, 0.05], atol=1e-9)
    handle = tip[1] - np.array([0.1, 0])
    np.testing.assert_allclose(seen["handle_from_grip.y"], handle - seen["grip.y"], atol=1e-9)
    np.testing.assert_allclose(seen["mug.y"], handle - task.mug.handle[0] * np.sin(0.3), atol=1e-9)
    np.testing.assert_allclose(seen["mug.axis1_y"], np.sin(0.3))


@pytest.mark.parametrize(
    ("share", "offset", "yaw", "on"),
    [
        (0.5, (0, 0, 0), 0.0, True),
        (0.5, (0, 0, 0), 0.5, True),
        (0.5, (0.016, 0, 0.016), 0.0, True),
        (0.5, (0.019, 0, 0), 0.0, False),
        (0.5, (0, 0, -0.019), 0.0, False),
        (-0.1, (0, 0, 0), 0.0, False),
        (1.1, (0, 0, 0), 0.0, False),
    ],
    ids=["middle", "turned", "edge", "beside", "above", "before", "behind"],
)
def test_on_the_peg_is_where_the_peg_goes_through_the_handle(task, start, share, offset, yaw, on):
    batch = new_batch(task, 1)
    task.reset(batch, mug_at(task, start, along_peg(task, share) + offset, yaw))
    assert task.on_peg(batch) == [on]


def test_the_peg_bears_a_mug_whose_handle_is_over_it(task, start):
    """And no other: whoever lets go too early sees it fall."""
    batch = new_batch(task, 2)
    task.reset(batch, mug_at(task, start, [along_peg(task, 0.5), along_peg(task, -0.2)]))
    batch.step(nstep=1000)
    batch.forward()
    assert task.on_peg(batch).tolist() == [True, False]
    # its weight has turned it about the peg
    assert batch.qpos[0, task.pose_of("mug")][2] < task.tree.peg[0, 2] - 0.03
    assert batch.qpos[1, task.pose_of("mug")][2] < 0.06
    assert np.abs(batch.qvel).max() < 0.5


def test_an_expert_hangs_it(task):
    rng = np.random.default_rng(0)
    demonstrations, success = attempt(task, task.sample_starts(rng, 20), rng, threads=2)
    assert success.mean() >= 0.9
    # and with little force: what it takes is far from what the arm can do
    for demonstration in demonstrations:
        assert (np.abs(demonstration.torque) < 0.5 * task.robot.torque_limit).all()


@pytest.fixture(scope="module")
def shown(task):
    """Positions of a demonstration, at the rate of a policy, and when the hand was opened, s."""
    rng = np.random.default_rng(0)
    (demonstration,), _ = attempt(task, task.sample_starts(rng, 1), rng)
    closed = np.flatnonzero(demonstration.gripper[:, 0] < task.opened[0])
    return demonstration.qpos[::10], closed[-1] * 0.002


def judge(task, trajectory):
    monitor, running = task.monitor(2), np.array([True, False])
    batch = new_batch(task, 2)
    for k, qpos in enumerate(trajectory):
        task.reset(batch, np.tile(qpos, (2, 1)))
        monitor.update(batch, PERIOD_S * k, running)
    kind, diverged = monitor.failures(running)
    assert diverged == "diverged"
    return monitor.success_time_s[0], kind


def test_half_a_second_after_the_hand_has_left_it_counts(task, shown):
    positions, released_s = shown
    success_s, kind = judge(task, positions)
    assert kind == ""
    assert released_s + 0.5 < success_s < released_s + 1.0


@pytest.mark.parametrize(
    ("frames", "kind"),
    [
        (["start"], "not_grasped"),
        (["lifted"], "not_released"),
        (["lifted", "start"], "dropped"),
        (["lifted", "onto", "start"], "missed"),
        (["lifted", "onto", "hung", "start"], "missed"),
        # the hand is where it held the mug, however long
        (["lifted", *["onto"] * 40], "not_released"),
        (["lifted", "onto", *["hung"] * 25], "not_released"),
        (["lifted", "onto", *["hung"] * 26, "start"], ""),
    ],
)
def test_how_it_went_is_named(task, shown, frames, kind):
    positions, released_s = shown
    at_end_of_grasp = int(released_s / PERIOD_S)
    height = positions[:, task.pose_of("mug")][:, 2]
    at = {
        "start": positions[0],
        "lifted": positions[np.argmax(height > 0.1)],
        "onto": positions[at_end_of_grasp],
        "hung": positions[-1],
    }
    success_s, found = judge(task, [at[name] for name in frames])
    assert found == kind
    assert np.isnan(success_s) == bool(kind)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"mug_diameter_m": 0.075}, "mug_diameter_m: found 0.075; allowed: up to 0.07"),
        ({"peg_diameter_m": 0.036}, "peg_diameter_m: found 0.036; allowed: below .* 0.035"),
        ({"mug_x_m": [0.5, 0.4]}, r"mug_x_m: found \[0.5, 0.4\]; allowed: low below high"),
        ({"mug_y_m": [0, 0]}, r"mug_y_m: found \[0, 0\]; allowed: low below high"),
        ({"mug_y_m": [0, 0.1]}, r"mug_y_m: found \[0, 0.1\]; allowed: up to .*clear of the tree"),
    ],
)
def test_what_cannot_be_done_is_refused(changes, message):
    with pytest.raises(ValueError, match=message):
        make_task({**SHIPPED, **changes})
