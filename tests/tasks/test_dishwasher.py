import numpy as np
import pytest
import yaml

from t2l.demos.expert import attempt
from t2l.sim import apply_position_gains, make_batch
from t2l.tasks import make_task
from t2l.tasks.dishwasher import PLACE
from tests.conftest import ROOT

SHIPPED = yaml.safe_load((ROOT / "config/tasks/dishwasher.yaml").read_text())


@pytest.fixture(scope="module")
def task():
    return make_task(SHIPPED)


def columns(task, *joints):
    return [task.model.joint(name).qposadr[0] for name in joints]


def at_starts(task, n, door=0.0):
    starts = task.sample_starts(np.random.default_rng(3), n)
    starts[:, columns(task, "door")] = door
    batch = make_batch(task.model, n)
    apply_position_gains(batch, task.robot.joints, 512.0, 24.0)
    task.reset(batch, starts)
    return batch, starts


def test_starts_are_where_the_file_says_and_differ(task):
    place = task.sample_starts(np.random.default_rng(3), 300)[:, columns(task, *PLACE)]
    yaw = SHIPPED["yaw_rad"]
    ranges = (*(SHIPPED[key] for key in ("front_x_m", "front_y_m")), [-yaw, yaw])
    for values, (low, high) in zip(place.T, ranges, strict=True):
        assert low <= values.min() < low + 0.1 * (high - low)
        assert high >= values.max() > high - 0.1 * (high - low)


# half open, it is where the hand is
@pytest.mark.parametrize("door", [0.0, 1.0, 1.3])
def test_a_door_that_nobody_touches_stays(task, door):
    """Its spring bears it, and the dishwasher does not creep."""
    batch, starts = at_starts(task, 5, door)
    batch.step(nstep=500)
    moved = batch.qpos - starts
    np.testing.assert_allclose(moved[:, columns(task, "door", *PLACE)], 0, atol=1e-3)


def test_observations_are_what_their_names_say(task):
    batch, starts = at_starts(task, 4, door=0.5)
    seen = dict(zip(task.observation_names, task.observe(batch).T, strict=True))
    own = task.observation_names[: task.robot_observation_size]
    assert "door.angle" not in own
    np.testing.assert_allclose(seen["door.angle"], 0.5)
    x, y, yaw = starts[:, columns(task, *PLACE)].T
    # the bar has come towards the robot and down, on the circle of the hinge
    radius = np.hypot(np.hypot(seen["bar.x"] - x, seen["bar.y"] - y), seen["bar.z"] - 0.08)
    np.testing.assert_allclose(radius, 0.33, atol=1e-9)
    np.testing.assert_allclose(seen["bar.z"], 0.08 + 0.33 * np.cos(0.5))
    assert (seen["bar.x"] < x).all()
    np.testing.assert_allclose(seen["bar.axis_x"], -np.sin(yaw), atol=1e-9)
    np.testing.assert_allclose(seen["bar_from_grip.z"], seen["bar.z"] - seen["grip.z"])


def test_an_expert_opens_it_and_nothing_else(task):
    rng = np.random.default_rng(0)
    starts = task.sample_starts(rng, 20)
    demonstrations, success = attempt(task, starts, rng, threads=2)
    assert success.mean() >= 0.9
    for start, demonstration in zip(starts, demonstrations, strict=True):
        last = demonstration.qpos[-1]
        place = columns(task, *PLACE)
        np.testing.assert_allclose(last[place], start[place], atol=1e-3)
        # and with little force: what it takes is far from what the arm can do
        assert (np.abs(demonstration.torque) < task.robot.torque_limit).all()


@pytest.fixture(scope="module")
def pulled(task):
    """The positions of a demonstration that pulls the door open."""
    rng = np.random.default_rng(0)
    (demonstration,), _ = attempt(task, task.sample_starts(rng, 1), rng)
    return demonstration.qpos


@pytest.mark.parametrize(
    ("angles", "held", "kind"),
    [
        ([0.0, 0.0], True, "not_moved"),
        ([0.3, 0.6], False, "slipped"),
        ([0.3, 0.6], True, "not_opened"),
        ([0.6, 1.06], True, ""),
        # what was open once is open
        ([1.06, 0.5], False, ""),
    ],
)
def test_how_it_went_is_named(task, pulled, angles, held, kind):
    monitor, running = task.monitor(2), np.array([True, False])
    batch, door = make_batch(task.model, 2), columns(task, "door")
    for k, angle in enumerate(angles):
        qpos = pulled[np.argmin(np.abs(pulled[:, door[0]] - angle))].copy()
        if not held:
            qpos[task.arm_qpos] = task.robot.home
        task.reset(batch, np.tile(qpos, (2, 1)))
        monitor.update(batch, 0.1 * (k + 1), running)
    assert monitor.failures(running) == [kind, "diverged"]
    assert np.isnan(monitor.success_time_s[0]) == bool(kind)


@pytest.mark.parametrize("key", ["front_x_m", "front_y_m"])
def test_an_empty_range_is_refused(key):
    with pytest.raises(ValueError, match=rf"{key}: found \[0.7, 0.6\]; allowed: low below high"):
        make_task({**SHIPPED, key: [0.7, 0.6]})
