from dataclasses import replace

import numpy as np
import pytest

from t2l.environment.interface import observation_names, scale_per_joint
from t2l.environment.limits import JITTER_RAD_S, LIMITS
from t2l.errors import ConfigurationError
from t2l.gains import Cell
from t2l.hardware import BackendError
from t2l.hardware.virtual import VirtualRobot
from t2l.transfer.deploy import Rollouts, deploy
from t2l.transfer.errors import (
    nn_error,
    observation_table,
    rollout_table,
    shaking,
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


def calm(n):
    """Without what is drawn anew in every rollout, and without the friction that stops a gentle
    policy short of its goal."""
    drawn = ("policy_latency", "velocity_noise", "position_noise")
    return VirtualRobot(ROBOT, n, absent=(*drawn, "wrist_friction"))


def identified(parameters=PARAMETERS):
    return IdentifiedRobot(ROBOT, 2, parameters, 100)


def reach(robot, n=2, policy=None, **changes):
    starts = np.tile(CENTRE, (n, 1))
    arguments = {"policy_rate_hz": 50.0, "duration_s": 3.0, "workspace": WORKSPACE} | changes
    policy = policy or proportional()
    return deploy(robot, policy, TASK, GENTLE, CELL, starts, starts + 0.1, **arguments)


def test_the_robot_is_led_to_its_goal():
    rollouts = reach(calm(2))
    assert rollouts.success.all()
    assert rollouts.stopped == ("", "")
    assert rollouts.q.shape == (300, 2, 7)
    assert rollouts.action.shape == (150, 2, 7)
    # a command holds for two samples
    np.testing.assert_array_equal(rollouts.q_des[0::2], rollouts.q_des[1::2])


def test_a_robot_that_equals_its_simulator_shows_no_error():
    first, again = (reach(identified()) for _ in range(2))
    assert trajectory_error(first, again).max() == 0
    table = rollout_table(proportional(), CELL, 1, first, again)
    assert (table.nn_error == 0).all()
    heavier = reach(identified({**PARAMETERS, "armature": np.full(7, 0.5)}))
    assert trajectory_error(first, heavier).min() > 1e-5


def test_policy_outputs_are_compared_where_both_decided():
    """Three decisions of two robots; the second is stopped before its last two."""
    none, nobs = np.full(1, np.nan), 2
    real = np.zeros((3, 2, nobs))
    sim = np.zeros((3, 2, nobs))
    sim[:, 0] = [[3.0, 0.0], [0.0, 4.0], [0.0, 0.0]]
    sim[0, 1], sim[1:, 1] = [1.0, 1.0], np.nan
    runs = [
        Rollouts(none, none, none, none, seen, none, none, none, ("", "")) for seen in (real, sim)
    ]

    class Same:
        def action(self, observation):
            return observation

    # √((9/2 + 16/2 + 0) / 3) and √((1 + 1) / 2)
    np.testing.assert_allclose(nn_error(Same(), *runs), [np.sqrt(12.5 / 3), 1.0])


def test_one_after_another_is_as_side_by_side(tmp_path):
    together = reach(calm(3), n=3, duration_s=0.5)
    robot = calm(1)
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


def test_torque_is_clamped_and_what_is_too_fast_stopped_alone():
    # 1.5 rad ahead of the wrist is 16 times its torque limit, which then makes it too fast
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
    assert "velocity of fr3_joint" in stopped
    asked = LIMITS.index("torque")
    assert rollouts.violated[0, 1, asked]  # and it went on
    last = np.flatnonzero(np.isfinite(rollouts.q[:, 1, 0]))[-1]
    assert 0 < last < 99
    assert np.isfinite(rollouts.q[:, 0]).all()
    # a command is given again at each of the ten ticks of a sample, to look at the robot between
    held = np.array(sent)[10 * last :: 10, 1]
    np.testing.assert_array_equal(held, rollouts.q[[last] * (100 - last), 1])
    assert rollouts.success.tolist() == [True, False]
    table = rollout_table(policy, CELL, 3, rollouts, rollouts)
    assert table.trajectory_error.tolist() == [0.0, 0.0]
    assert table.duration_s.tolist() == [1.0, last / 100]
    assert table.jitter_failure.tolist() == [False, False]
    assert [bool(reason) for reason in table.stopped] == [False, True]
    assert table.success.tolist() == [True, False]
    assert (table.seed == 3).all()


def test_what_is_too_fast_between_two_samples_is_stopped_at_the_next():
    robot = calm(2)
    read, reads = robot.read, []

    def shown():
        state = read()
        reads.append(1)
        # of 10 ticks a sample, in the middle of the 30th; `start` reads once
        if len(reads) == 1 + 295:
            state.dq[1, 0] = 2.7
        return state

    robot.read = shown
    rollouts = reach(robot)
    assert rollouts.stopped == ("", "velocity of fr3_joint1 2.7 rad/s; allowed: -2.62 to 2.62")
    assert rollouts.success.tolist() == [True, False]
    assert np.isfinite(rollouts.q[:, 0]).all()
    assert np.isfinite(rollouts.q[:31, 1]).all()
    assert np.isnan(rollouts.q[31:, 1]).all()


def made(q, dq, stopped=""):
    """Rollouts of one robot with one joint: q and dq (nsample,), NaN after it was stopped."""
    q, dq = (np.array(values, float)[:, None, None] for values in (q, dq))
    seen, empty = np.zeros((len(q), 1, 4)), np.zeros((len(q), 1, 1))
    return Rollouts(
        time=np.arange(len(q)) / 100, q=q, dq=dq, q_des=q, observation=seen, action=empty,
        violated=np.zeros((len(q), 1, 4), bool), success=np.array([not stopped]),
        stopped=(stopped,),
    )  # fmt: skip


def test_a_robot_that_was_stopped_is_compared_to_the_end_where_it_stands():
    sim = made([0.0, 1.0, 2.0, 3.0], [0.0, 1.0, 1.0, 0.5])
    real = made([0.0, 1.5, np.nan, np.nan], [0.0, 3.0, np.nan, np.nan], "too fast")
    # positions 0, 0.5, 0.5, 1.5 apart, velocities 0, 2, 1, 0.5
    expected = (0.25 + 0.25 + 2.25 + 4.0 + 1.0 + 0.25) / 4
    assert trajectory_error(real, sim) == pytest.approx(expected)
    assert trajectory_error(sim, real) == pytest.approx(expected)


def test_a_rollout_that_was_stopped_at_once_has_an_error_too():
    real = made([0.2, np.nan], [0.0, np.nan], "out of the workspace")
    assert trajectory_error(real, made([0.2, 0.4], [0.0, 1.0])) == pytest.approx((0.04 + 1) / 2)


def test_the_error_is_a_mean_over_joints():
    one, other = made([0.0, 0.0], [0.0, 0.0]), made([0.0, 1.0], [0.0, 2.0])

    def with_two_more_joints(run):
        more = np.zeros((2, 1, 2))
        return replace(run, **{k: np.concatenate([getattr(run, k), more], 2) for k in ("q", "dq")})

    assert trajectory_error(one, other) == pytest.approx(2.5)
    wider = trajectory_error(with_two_more_joints(one), with_two_more_joints(other))
    assert wider == pytest.approx(2.5 / 3)


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
    rollouts = replace(rollouts, dq=dq)
    calm, shakes = shaking(rollouts)
    assert calm == 0
    assert shakes == pytest.approx(0.06, rel=0.02)
    assert shakes > JITTER_RAD_S
    table = rollout_table(proportional(), CELL, 1, rollouts, rollouts)
    assert table.jitter_failure.tolist() == [False, True]
    # at its goal, and no success
    assert rollouts.success.all()
    assert table.success.tolist() == table.success_sim.tolist() == [True, False]


def test_a_rollout_that_was_stopped_failed_but_not_by_jitter():
    calm = np.zeros(300)
    calm[290:] = np.nan
    real, sim = made(calm, calm, "out of the workspace"), made(np.zeros(300), np.zeros(300))
    policy = Proportional(1, 1.0)
    table = rollout_table(policy, CELL, 1, real, sim)
    assert table.jitter_failure.tolist() == [False]
    assert np.isnan(table.jitter_rad_s[0])
    assert table.jitter_failure_sim.tolist() == [False]
    assert table.stopped.tolist() == ["out of the workspace"]
    assert not table.success[0]


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
