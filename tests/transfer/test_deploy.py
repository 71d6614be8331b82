import numpy as np
import pytest

from t2l.errors import ConfigurationError
from t2l.gains import Cell
from t2l.hardware import BackendError
from t2l.hardware.virtual import VirtualRobot
from t2l.rl.interface import observation_names, scale_per_joint
from t2l.transfer.deploy import deploy
from t2l.transfer.errors import (
    JITTER_RAD_S,
    jitter,
    observation_table,
    rollout_table,
    trace_table,
    trajectory_error,
)
from t2l.transfer.identified import IdentifiedRobot
from tests.defaults import WORKSPACE, shipped
from tests.hardware.made import Proportional
from tests.rl.test_environments import CENTRE, PARAMETERS, ROBOT, joint_delta

CELL = Cell(128, 16)
TASK = shipped("joint_reach")
GENTLE = joint_delta(scale_per_joint((0.2, 0.04), ROBOT))


def proportional(gain=3.0):
    return Proportional(len(ROBOT.joints), gain)


def virtual(n):
    return VirtualRobot(ROBOT, n)


def identified(parameters=PARAMETERS):
    return IdentifiedRobot(ROBOT, 2, parameters, 100)


def reach(robot, n=2, policy=None, **changes):
    starts = np.tile(CENTRE, (n, 1))
    arguments = {"policy_rate_hz": 50.0, "duration_s": 3.0, "workspace": WORKSPACE} | changes
    policy = policy or proportional()
    return deploy(robot, policy, TASK, GENTLE, CELL, starts, starts + 0.1, **arguments)


def test_the_robot_is_led_to_its_goal():
    rollouts = reach(virtual(2))
    assert rollouts.success.all()
    assert rollouts.stopped == ("", "")
    assert rollouts.q.shape == (300, 2, 7)
    assert rollouts.action.shape == (150, 2, 7)
    # a command holds for two samples
    np.testing.assert_array_equal(rollouts.q_des[0::2], rollouts.q_des[1::2])


def test_a_robot_that_equals_its_simulator_shows_no_error():
    first, again = (reach(identified()) for _ in range(2))
    assert trajectory_error(first, again).max() == 0
    table = rollout_table(proportional(), CELL, first, again)
    assert (table.nn_error == 0).all()
    heavier = reach(identified({**PARAMETERS, "armature": np.full(7, 0.5)}))
    assert trajectory_error(first, heavier).min() > 1e-5


def test_one_after_another_is_as_side_by_side(tmp_path):
    together = reach(virtual(3), n=3, duration_s=0.5)
    robot = virtual(1)
    in_turn = reach(robot, n=3, duration_s=0.5, folder=tmp_path)
    np.testing.assert_allclose(in_turn.q, together.q, atol=1e-12)
    assert len(list(tmp_path.iterdir())) == 3

    def refuse(*_):
        raise AssertionError("nothing is left to run")

    robot.start = refuse
    kept = reach(robot, n=3, duration_s=0.5, folder=tmp_path)
    np.testing.assert_array_equal(kept.q, in_turn.q)
    assert kept.stopped == in_turn.stopped


def _without(name):
    def drop(content):
        return {key: value for key, value in content.items() if key != name}

    return drop


@pytest.mark.parametrize(
    "damage",
    [
        lambda path: path.write_bytes(path.read_bytes()[:-300]),
        lambda path: path.write_bytes(b"{}"),
        lambda path: np.savez(path, **_without("stopped")(np.load(path))),
        lambda path: np.savez(path, **{**np.load(path), "q": np.zeros((3, 1, 7))}),
        lambda path: np.savez(path, **{**np.load(path), "success": np.array(["yes"])}),
        lambda path: path.unlink() or path.mkdir(),
    ],
    ids=["cut", "foreign", "lacking", "shape", "type", "folder"],
)
def test_a_kept_rollout_that_is_broken_is_run_anew(tmp_path, caplog, damage):
    before = reach(virtual(1), duration_s=0.2, folder=tmp_path)
    damage(tmp_path / "000.npz")
    again = reach(virtual(1), duration_s=0.2, folder=tmp_path)
    np.testing.assert_array_equal(again.q, before.q)
    assert {p.name for p in tmp_path.iterdir()} == {"000.npz", "001.npz", "000.npz.broken"}
    assert "set aside as 000.npz.broken" in caplog.text


def test_a_command_that_must_not_be_sent_stops_its_robot_alone():
    # 1.5 rad ahead of the wrist is more than its torque limit
    wild, policy = joint_delta(scale_per_joint((0.2, 1.5), ROBOT)), proportional(gain=20.0)
    starts = np.tile(CENTRE, (2, 1))
    goals = np.array([starts[0], starts[0] + 0.3])
    robot = virtual(2)
    sent = []
    send = robot.send
    robot.send = lambda q_des, period_s: sent.append(q_des.copy()) or send(q_des, period_s)
    rollouts = deploy(robot, policy, TASK, wild, CELL, starts, goals, 50.0, 1.0, WORKSPACE)
    still, stopped = rollouts.stopped
    assert still == ""
    assert "torque of fr3_joint5" in stopped
    assert "allowed: -12 to 12" in stopped
    assert np.isnan(rollouts.q[:, 1]).all()
    assert np.isfinite(rollouts.q[:, 0]).all()
    assert np.abs(np.array(sent)[:, 1] - starts[1]).max() < 1e-3  # held where it was
    assert rollouts.success.tolist() == [True, False]
    table = rollout_table(policy, CELL, rollouts, rollouts)
    assert np.isnan(table.trajectory_error[1])
    assert table.duration_s.tolist() == [1.0, 0.0]


def test_a_policy_that_is_no_number_never_reaches_the_robot():
    broken = proportional(gain=np.nan)
    rollouts = reach(virtual(1), n=1, policy=broken, duration_s=0.2)
    assert "position command of fr3_joint1 nan" in rollouts.stopped[0]


@pytest.mark.parametrize("error", [BackendError("lost"), KeyboardInterrupt()], ids=repr)
def test_whatever_ends_a_deployment_the_robot_is_held_first(error):
    robot, held = virtual(1), []
    steps = iter(range(100))
    send = robot.send

    def fails_later(q_des, period_s):
        if next(steps) == 20:
            raise error
        send(q_des, period_s)

    robot.send, robot.hold = fails_later, lambda: held.append(True)
    with pytest.raises(type(error)):
        reach(robot, n=1)
    assert held == [True]


def test_jitter_is_what_shakes_at_the_end():
    rollouts = reach(identified())
    dq = np.zeros_like(rollouts.dq)
    dq[:100] = 1.0  # fast at first
    time = rollouts.time[:, None]
    dq[:, 1, 4:5] += 0.06 * np.sqrt(2) * np.sin(2 * np.pi * 11 * time)
    object.__setattr__(rollouts, "dq", dq)
    calm, shaking = jitter(rollouts)
    assert calm == 0
    assert shaking == pytest.approx(0.06, rel=0.02)
    assert shaking > JITTER_RAD_S
    dq[150:, 1] = np.nan  # stopped after 1.5 s
    assert np.isnan(jitter(rollouts)[1])
    table = rollout_table(proportional(), CELL, rollouts, rollouts)
    assert not table.jitter_failure[0]
    assert table.jitter_failure.isna().tolist() == [False, True]


def test_poses_are_reached_too_and_tables_tell_all():
    task = shipped("end_effector_reach")

    class Still(Proportional):
        def act(self, history):
            return np.zeros((len(history), 1, self.action_size))

    draw = np.random.default_rng(0)
    starts, goals = task.sample_starts(draw, 2), task.sample_goals(draw, 2)
    rest = (task, GENTLE, CELL, starts, goals, 20.0, 0.5, WORKSPACE)
    rollouts = deploy(identified(), Still(len(ROBOT.joints)), *rest)
    seen = observation_table(rollouts, rollouts, observation_names(task))
    assert len(seen) == 2 * 2 * 10
    assert set(observation_names(task)) <= set(seen)
    trace = trace_table(rollouts, rollouts, ROBOT.joints)
    assert len(trace) == 2 * 2 * 50


def test_rates_that_do_not_fit_are_refused():
    with pytest.raises(ConfigurationError, match="policy rate: found 30 Hz; allowed: a divisor"):
        reach(virtual(1), n=1, policy_rate_hz=30.0)
