import numpy as np
import pytest

from t2l.errors import ConfigurationError
from t2l.rl.hyperparameters import COLUMNS, of_task
from t2l.sim import make_batch
from t2l.tasks.open_drawer import Measured
from t2l.tasks.terms import Moment
from tests.defaults import shipped
from tests.tasks.scripted import PERIOD_S, play, scene

TASK = shipped("open_drawer")
FORWARD, UP = np.array([1.0, 0.0, 0.0]), np.array([0.0, 0.0, 1.0])


def pull(t, n, closes=True, far_m=0.32):
    """In front of the handle, to it, close, pull."""
    handle = np.tile(TASK.handle, (n, 1))
    if t < 2.0:
        return handle - 0.12 * FORWARD, True, FORWARD, UP
    if t < 3.0:
        return handle, True, FORWARD, UP
    pulled = min(max(t - 3.5, 0.0) * 0.15, far_m)
    return handle - pulled * FORWARD, not closes, FORWARD, UP


@pytest.mark.parametrize(
    ("way", "solved"),
    [({}, True), ({"closes": False}, False), ({"far_m": 0.1}, False)],
    ids=["pulls it open", "does not close the hand", "pulls it half open"],
)
def test_a_scripted_hand_is_judged_right(way, solved):
    environment = scene(TASK, 3, horizon_s=8.0)
    ended, paid = play(environment, lambda t, seen, goal: pull(t, 3, **way))
    assert ended.success.tolist() == [solved] * 3
    assert not ended.failed.any()
    # a second, it pays more the further it is open: 7.5 · 2 · 0.2 and the stages at least
    assert (paid[-1] - paid[100] > 3 * PERIOD_S).tolist() == [solved] * 3


def moment(**changes):
    """What terms see at the end of a second."""
    none = np.zeros(1)
    seen = {
        "open_m": none, "speed_m_s": none, "to_handle": np.zeros((1, 3)), "forward": none,
        "across": none, "above": none, "below": none, "closed_m": none,
    }  # fmt: skip
    seen |= {name: np.atleast_1d(value) for name, value in changes.items() if name in seen}
    still = np.zeros((1, 7))
    dq = still + changes.get("dq", 0.0)
    change = np.zeros((1, 8)) + changes.get("change", 0.0)
    return Moment(TASK, None, still, dq, None, Measured(**seen), change=change, period_s=1.0)


def test_rewards_are_the_published_templates():
    far = moment(to_handle=[[0.5, 0.0, 0.0]], dq=0.5, change=0.2)
    assert sum(TASK.paid(far))[0] == pytest.approx(2 / 1.25**2 - 1e-4 * 7 * 0.25 - 1e-2 * 8 * 0.04)
    grasped = moment(
        to_handle=[[0.02, 0.0, 0.0]], forward=0.9, across=-0.5, above=0.01, below=0.02,
        closed_m=0.05, open_m=0.25,
    )  # fmt: skip
    near = 2 * 2 / (1 + 0.02**2) ** 2
    turned = 0.5 * (0.81 - 0.25) / 2
    held = 5 * (0.08 - 0.03) + 0.125 + 0.5 * 0.05
    opened = 7.5 * 2 * 0.25 + 1.5
    assert sum(TASK.paid(grasped))[0] == pytest.approx(near + turned + held + opened)
    # fingers on one side of the bar do not hold it
    beside = moment(above=0.01, below=-0.02, open_m=0.25)
    assert sum(TASK.paid(beside))[0] == pytest.approx(4 + 7.5 * 0.25 + 0.5)


def test_what_is_measured_of_a_hand_that_points_at_the_handle():
    """The axes of the hand as it hangs over the table at home: down, fingers across."""
    environment = scene(TASK, 1)
    qpos = TASK.sample_starts(np.random.default_rng(0), 1)
    qpos[:, TASK.arm_qpos] = TASK.robot.home
    environment.place(qpos, np.empty((1, 0)))
    seen = TASK.measure(environment.simulator.batch, None)
    assert abs(seen.forward[0]) < 0.01
    # level fingers are as far above the handle as below it
    np.testing.assert_allclose(seen.above, -seen.below, atol=1e-3)
    np.testing.assert_allclose(seen.closed_m, 0.0, atol=1e-9)
    assert seen.open_m == 0


def test_the_drawer_rests_closed_and_its_spring_pulls_it_back():
    batch = make_batch(TASK.model, 2)
    batch.qpos[:] = TASK.sample_starts(np.random.default_rng(0), 2)
    drawer = TASK.model.joint("drawer").qposadr[0]
    batch.qpos[1, drawer] = 0.1
    TASK.command(batch.ctrl, batch.qpos[:, TASK.arm_qpos], TASK.opened)
    batch.step(nstep=5)
    assert abs(batch.qpos[0, drawer]) < 1e-3
    # k x / m, with what damps it still at rest
    assert batch.qvel[1, TASK.model.joint("drawer").dofadr[0]] == pytest.approx(-0.01, rel=0.1)


def test_it_learns_with_the_studys_column():
    column = of_task(TASK)
    assert column == COLUMNS["drawer"]
    assert (column.rollout_steps, column.minibatches, column.normalised) == (96, 96, False)


def test_a_drawer_that_starts_inside_the_arm_is_refused():
    said = "starts of open_drawer: found drawer .* mm inside fr3_link7; allowed: things apart"
    with pytest.raises(ConfigurationError, match=said):
        scene(shipped("open_drawer", handle_x_m=0.35), 2)


def test_fingers_must_slide():
    with pytest.raises(ValueError, match="whose gripper has no two sliding fingers"):
        shipped("open_drawer", robot="ur5e_2f85", start_rad=[])
