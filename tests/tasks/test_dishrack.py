import numpy as np
import pytest
import yaml
from scipy.spatial.transform import Rotation

from t2l.demos.expert import attempt
from t2l.sim import apply_position_gains, make_batch
from t2l.tasks import make_task
from t2l.tasks.table_top import furniture_joints
from tests.conftest import ROOT

NAMES = ("dishrack_loading", "dishrack_unloading")
SHIPPED = {name: yaml.safe_load((ROOT / f"config/tasks/{name}.yaml").read_text()) for name in NAMES}
LOADING, UNLOADING = NAMES
SUCCESS = ""


@pytest.fixture(scope="module")
def tasks():
    return {name: make_task(SHIPPED[name]) for name in NAMES}


@pytest.fixture(params=NAMES)
def task(tasks, request):
    return tasks[request.param]


def places(task, qpos, name):
    return qpos[:, [task.model.joint(joint).qposadr[0] for joint in furniture_joints(name)]]


def plate(task):
    address = task.model.joint("plate").qposadr[0]
    return slice(address, address + 7)


def at(task, qpos):
    batch = make_batch(task.model, len(qpos))
    apply_position_gains(batch, task.robot.joints, 512.0, 24.0)
    task.reset(batch, qpos)
    return batch


def test_starts_are_where_the_file_says_and_differ(task):
    starts = task.sample_starts(np.random.default_rng(3), 300)
    parameters = SHIPPED[task.name]
    yaw = parameters["yaw_rad"]
    for name in ("rack", "pad"):
        ranges = (*(parameters[f"{name}_{c}_m"] for c in "xy"), [-yaw, yaw])
        for values, (low, high) in zip(places(task, starts, name).T, ranges, strict=True):
            assert low <= values.min() < low + 0.1 * (high - low)
            assert high >= values.max() > high - 0.1 * (high - low)


def test_a_plate_that_nobody_touches_stays(task):
    """It leans in its slot, and rack and pad do not creep."""
    starts = task.sample_starts(np.random.default_rng(3), 30)
    batch = at(task, starts)
    batch.step(nstep=500)
    moved = batch.qpos - starts
    np.testing.assert_allclose(moved[:, plate(task)][:, :3], 0, atol=2e-3)
    for name in ("rack", "pad"):
        np.testing.assert_allclose(places(task, moved, name), 0, atol=1e-4)


def test_observations_are_what_their_names_say(task):
    starts = task.sample_starts(np.random.default_rng(3), 4)
    seen = dict(zip(task.observation_names, task.observe(at(task, starts)).T, strict=True))

    def vector(name):
        return np.stack([seen[f"{name}{c}"] for c in "xyz"], axis=1)

    own = task.observation_names[: task.robot_observation_size]
    assert not any("plate" in name for name in own)
    pose = starts[:, plate(task)]
    rotation = Rotation.from_quat(pose[:, 3:], scalar_first=True).as_matrix()
    np.testing.assert_allclose(vector("plate."), pose[:, :3], atol=1e-9)
    np.testing.assert_allclose(vector("plate.axis_"), rotation[:, :, 2], atol=1e-9)
    rim = pose[:, :3] + 0.052 * rotation[:, :, 1]
    np.testing.assert_allclose(vector("rim_from_grip."), rim - vector("grip."), atol=1e-9)
    x, y, yaw = places(task, starts, task.goal).T
    np.testing.assert_allclose(seen[f"{task.goal}.along_y"], np.sin(yaw), atol=1e-9)
    goal = np.stack([x, y, np.full(4, 0.01)], axis=1)
    np.testing.assert_allclose(vector(f"{task.goal}_from_plate."), goal - pose[:, :3], atol=1e-9)


def test_a_plate_starts_in_its_slot(task):
    """Its lower edge between the walls, its face at the top of one of them."""
    starts = task.sample_starts(np.random.default_rng(3), 100)
    pose = starts[:, plate(task)]
    x, y, yaw = places(task, starts, task.origin).T
    into = Rotation.from_euler("z", -yaw[:, None])
    middle = into.apply(pose[:, :3] - np.stack([x, y, np.full(100, 0.01)], axis=1))
    rotation = into * Rotation.from_quat(pose[:, 3:], scalar_first=True)
    thick, wide = (SHIPPED[task.name][f"{key}_m"] for key in ("plate_thickness", "slot_width"))
    front = middle + rotation.apply([0, -0.06, thick / 2])
    np.testing.assert_allclose(front[:, 2], 0, atol=1e-9)
    assert (np.abs(front[:, 1]) < wide / 2).all()
    assert (np.abs(middle + rotation.apply([0, -0.06, -thick / 2]))[:, 1] < wide / 2).all()
    edge = np.array([0, -wide / 2, 0.06])
    depth = rotation.inv().apply(edge - middle)[:, 2]
    np.testing.assert_allclose(depth, thick / 2, atol=1e-9)


@pytest.fixture(scope="module")
def shown(tasks):
    """Starts, demonstrations and successes of each task."""

    def show(task):
        rng = np.random.default_rng(0)
        starts = task.sample_starts(rng, 10)
        return starts, *attempt(task, starts, rng)

    return {name: show(task) for name, task in tasks.items()}


def test_an_expert_does_it_and_moves_nothing_else(task, shown):
    starts, demonstrations, success = shown[task.name]
    assert success.mean() >= 0.9
    last = np.stack([each.qpos[-1] for each in demonstrations])
    for name in ("rack", "pad"):
        np.testing.assert_allclose(places(task, last - starts, name), 0, atol=2e-3)
    torque = np.concatenate([each.torque for each in demonstrations])
    assert (np.abs(torque) < task.robot.torque_limit).all()


def lying(height, tilt=0.0, aside=0.0):
    """The plate above the middle of the goal's surface, tilted about the slots' direction."""
    return [0, aside, height, np.cos(tilt / 2), np.sin(tilt / 2), 0, 0]


LYING, STANDING = 0.007, 0.06


@pytest.mark.parametrize(
    ("name", "pose", "kind"),
    [
        (LOADING, lying(STANDING, np.pi / 2), SUCCESS),
        (LOADING, lying(STANDING - 0.001, np.pi / 2 + 0.3, aside=-0.015), SUCCESS),
        (LOADING, lying(STANDING, np.pi / 2, aside=0.034), "beside_slot"),
        (LOADING, lying(0.07, 0.0), "beside_slot"),
        (LOADING, lying(LYING - 0.01, 0.0, aside=0.2), "dropped"),
        (UNLOADING, lying(LYING), SUCCESS),
        (UNLOADING, lying(LYING, aside=0.04), SUCCESS),
        (UNLOADING, lying(LYING, tilt=0.5), "tipped"),
        (UNLOADING, lying(LYING, tilt=np.pi), "tipped"),
        (UNLOADING, lying(LYING - 0.01, aside=0.15), "dropped"),
    ],
)
def test_how_it_went_is_named(tasks, name, pose, kind):
    task = tasks[name]
    qpos = task.sample_starts(np.random.default_rng(0), 2)
    x, y, yaw = places(task, qpos, task.goal)[0]
    turned, pose = Rotation.from_euler("z", yaw), np.array(pose)
    end = np.concatenate(
        [
            turned.apply(pose[:3]) + np.array([x, y, 0.01]),
            (turned * Rotation.from_quat(pose[3:], scalar_first=True)).as_quat(scalar_first=True),
        ]
    )
    lifted = end.copy()
    lifted[2] += 0.1
    monitor, running = task.monitor(2), np.array([True, False])
    batch = make_batch(task.model, 2)
    for k, each in enumerate([end, lifted, end, end, end]):
        qpos[:, plate(task)] = each
        task.reset(batch, qpos)
        monitor.update(batch, 0.1 * (k + 1), running)
    assert monitor.failures(running) == [kind, "diverged"]
    assert np.isnan(monitor.success_time_s[0]) == bool(kind)


@pytest.mark.parametrize(("until", "kind"), [(0.2, "not_grasped"), (0.65, "not_released")])
def test_what_is_left_in_the_middle_is_named(task, shown, until, kind):
    _, (demonstration, *_), _ = shown[task.name]
    monitor, running = task.monitor(1), np.array([True])
    batch = make_batch(task.model, 1)
    for k, qpos in enumerate(demonstration.qpos[: int(until * len(demonstration.qpos)) : 50]):
        task.reset(batch, qpos[None])
        monitor.update(batch, 0.1 * k, running)
    assert monitor.failures(running) == [kind]


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"plate_thickness_m": 0.075}, "plate_thickness_m: found 0.075; allowed: up to 0.07,"),
        ({"slot_width_m": 0.012}, "slot_width_m: found 0.012; allowed: from 0.014 up"),
        ({"rack_x_m": [0.6, 0.5]}, r"rack_x_m: found \[0.6, 0.5\]; allowed: low below high"),
        ({"pad_y_m": [-0.1, -0.1]}, r"pad_y_m: found \[-0.1, -0.1\]; allowed: low below high"),
        ({"pad_y_m": [-0.1, 0.0]}, "found gaps of .* m and .* m between rack and pad; allowed"),
    ],
)
def test_what_cannot_be_is_refused(change, message):
    with pytest.raises(ValueError, match=message):
        make_task({**SHIPPED[LOADING], **change})
