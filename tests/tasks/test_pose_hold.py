import mujoco
import numpy as np
import pytest

from t2l.errors import ConfigurationError
from t2l.sim.batch import make_batch
from t2l.tasks.disturbance import POINT, Forces, RandomPushes
from t2l.tasks.terms import Moment
from tests.defaults import shipped
from tests.tasks.scripted import lead

TASK = shipped("pose_hold")


def paid(task, remaining, change):
    at = Moment(task, None, None, None, None, remaining, change=change, period_s=0.02)
    return sum(task.paid(at)) / at.period_s


def test_the_two_rewards_are_the_studys():
    remaining = np.array([[0.1, 0, 0, 0, 0, 0, 0], [0.3, 0.4, 0, 0, 0, 0, 0]])
    change = np.array([[0.5, -0.5, 0, 0, 0, 0, 0], [1.0, 0, 0, 0, 0, 0, 0]])
    stiff = paid(TASK, remaining, change)
    np.testing.assert_allclose(stiff, [1 - np.tanh(1.0), 1 - np.tanh(25.0)])
    soft = TASK.reweighted({"lambda_rad2": 0.5, "change": 0.1})
    found = paid(soft, remaining, change)
    np.testing.assert_allclose(found, [1 - np.tanh(0.02) - 0.05, 1 - np.tanh(0.5) - 0.1])


@pytest.mark.parametrize(("beside", "solved"), [(0.0, True), (0.06, False)])
def test_a_scripted_arm_is_judged_right(beside, solved):
    home = TASK.sample_goals(np.random.default_rng(0), 4)
    # 0.06 rad of seven joints are 0.16 rad
    assert lead(TASK, home, home, home + beside).success.tolist() == [solved] * 4
    if solved:
        # an arm that goes where it is pushed does not come back
        assert not lead(TASK, home, home, home, follows=False).success.all()


def test_a_force_acts_at_the_tool_and_not_at_a_centre_of_mass():
    class Steady(Forces):
        def force(self, time_s):
            return np.array([[3.0, -4.0, 5.0]])

    batch = make_batch(TASK.model, 1)
    batch.qpos[:] = TASK.robot.home
    Steady(batch).apply(np.zeros(1))
    data = mujoco.MjData(TASK.model)
    data.qpos[:] = TASK.robot.home
    data.xfrc_applied[:] = batch.bind("xfrc_applied")[0]
    mujoco.mj_forward(TASK.model, data)
    jacobian = np.empty((3, TASK.model.nv))
    mujoco.mj_jacSite(TASK.model, data, jacobian, None, int(TASK.tool_sites[0]))
    point = TASK.model.body(POINT).id
    np.testing.assert_array_equal(data.xfrc_applied[point], [3.0, -4.0, 5.0, 0, 0, 0])
    torque, none = np.zeros(TASK.model.nv), np.zeros(3)
    # as MuJoCo applies it
    mujoco.mj_applyFT(
        TASK.model, data, data.xfrc_applied[point, :3], none, data.xipos[point], point, torque
    )
    np.testing.assert_allclose(torque, jacobian.T @ [3.0, -4.0, 5.0], atol=1e-12)
    assert TASK.model.body(POINT).mass[0] == 0


def test_every_window_has_one_push_within_its_bounds():
    n, rate_hz = 200, 100
    pushes = RandomPushes(
        make_batch(TASK.model, n), np.random.default_rng(0), 30.0, (0.2, 1.0), 2.0
    )
    pushes.begin(np.arange(n))
    time = np.arange(4 * rate_hz) / rate_hz
    size = np.array([np.linalg.norm(pushes.force(np.full(n, t)), axis=1) for t in time])
    for window in (size[: 2 * rate_hz], size[2 * rate_hz :]):
        length = (window > 0).sum(axis=0) / rate_hz
        assert length.min() >= 0.2 - 0.011
        assert length.max() <= 1.0 + 0.011
        # once begun, a push goes on as it is until it ends
        assert (np.diff((window > 0).astype(int), axis=0) == 1).sum(axis=0).max() <= 1
        assert all(len(np.unique(column[column > 0])) == 1 for column in window.T)
    assert size.max() <= 30.0
    assert size.max(axis=0).mean() == pytest.approx(20, rel=0.1)  # larger of two uniform ones


def test_pushes_must_fit_in_their_windows():
    with pytest.raises(ConfigurationError, match="longest_push_s: found 3; allowed: from shortest"):
        shipped("pose_hold", longest_push_s=3.0)
