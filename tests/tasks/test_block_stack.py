import mujoco
import numpy as np
import pytest

from t2l.sim import make_batch
from t2l.tasks import make_task


@pytest.fixture
def scene(task):
    """One simulation at a start, and a way to put the red block somewhere."""
    batch = make_batch(task.model, 1)
    task.reset(batch, task.sample_starts(np.random.default_rng(0), 1))
    red = task.model.joint("red_block").qposadr[0]
    blue = task.model.joint("blue_block").qposadr[0]

    def put_red(offset_from_blue):
        batch.qpos[:, red : red + 7] = batch.qpos[:, blue : blue + 7]
        batch.qpos[:, red : red + 3] += offset_from_blue
        batch.forward()

    return batch, put_red


def _judge(task, batch, put_red, offsets):
    monitor = task.monitor(1)
    running = np.ones(1, dtype=bool)
    for k, offset in enumerate(offsets):
        put_red(offset)
        monitor.update(batch, (k + 1) * 0.02, running)
    return monitor, monitor.failures(running)[0]


def test_a_stacked_block_that_stays_is_a_success(task, scene):
    monitor, failure = _judge(task, *scene, [(0, 0, 0.04)] * 20)
    assert failure == ""
    assert monitor.success_time_s[0] == pytest.approx(0.22)


@pytest.mark.parametrize(
    ("offsets", "kind"),
    [
        ([(0.1, 0, 0)] * 20, "not_grasped"),
        ([(0, 0, 0.2), (0.1, 0, 0)], "dropped"),
        ([(0.017, 0, 0.04)] * 20, "misplaced"),
        ([(0, 0, 0.047)] * 20, "misplaced"),
        ([(0, 0, 0.04)] * 9 + [(0.1, 0, 0)], "dropped"),
    ],
    ids=["never lifted", "dropped", "off centre", "hovering", "toppled before it counted"],
)
def test_what_is_not_a_stack_is_named(task, scene, offsets, kind):
    assert _judge(task, *scene, offsets)[1] == kind


def test_a_block_in_the_hand_is_not_released(task, scene):
    batch, put_red = scene
    site = task.model.site("grip").id
    blue = task.model.joint("blue_block").qposadr[0]
    batch.forward()
    offset = batch.bind("site_xpos")[0, site].copy()
    batch.forward()
    in_hand = batch.bind("site_xpos")[0, site] - batch.qpos[0, blue : blue + 3]
    assert _judge(task, batch, put_red, [in_hand] * 20)[1] == "not_released"
    assert offset.shape == (3,)


def test_starts_lie_in_the_workspace_with_room_for_the_fingers(task):
    starts = task.sample_starts(np.random.default_rng(3), 500)
    poses = task.block_poses(starts)
    for axis, bounds in enumerate((task.workspace_x_m, task.workspace_y_m)):
        assert poses[:, :, axis].min() >= bounds[0]
        assert poses[:, :, axis].max() <= bounds[1]
    gap = np.linalg.norm(poses[:, 0, :2] - poses[:, 1, :2], axis=1)
    assert gap.min() >= task.block_gap_m
    np.testing.assert_allclose(np.linalg.norm(poses[:, :, 3:], axis=2), 1)


def test_nothing_moves_at_a_start(task):
    starts = task.sample_starts(np.random.default_rng(3), 20)
    batch = make_batch(task.model, 20)
    task.reset(batch, starts)
    batch.step(nstep=250)
    np.testing.assert_allclose(batch.qpos, starts, atol=2e-3)


def tool_at(task, starts):
    data = mujoco.MjData(task.model)
    positions = []
    for start in starts:
        data.qpos[:] = start
        mujoco.mj_kinematics(task.model, data)
        positions.append(data.site("grip").xpos.copy())
    return positions


def test_observations_are_what_their_names_say(task):
    batch = make_batch(task.model, 2)
    starts = task.sample_starts(np.random.default_rng(3), 2)
    task.reset(batch, starts)
    observation = task.observe(batch)
    names = list(task.observation_names)
    assert observation.shape == (2, len(names))
    assert len(set(names)) == len(names)
    np.testing.assert_array_equal(observation[:, names.index("q.fr3_joint3")], starts[:, 2])
    np.testing.assert_allclose(
        observation[:, names.index("grip.x") : names.index("grip.x") + 3], tool_at(task, starts)
    )
    own = names[: task.robot_observation_size]
    assert not any("block" in name for name in own)
    poses = task.block_poses(starts)
    np.testing.assert_allclose(observation[:, names.index("blue_block.y")], poses[:, 1, 1])
    np.testing.assert_allclose(
        observation[:, names.index("blue_block_from_red_block.x")],
        poses[:, 1, 0] - poses[:, 0, 0],
    )


def test_a_workspace_without_room_is_refused(block_stack):
    with pytest.raises(ValueError, match="a diagonal of at least"):
        make_task({**block_stack, "workspace_x_m": [0.5, 0.51], "workspace_y_m": [0, 0.01]})
