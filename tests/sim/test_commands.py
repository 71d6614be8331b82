"""Commands that are late: by their stamps, and smoothly where derivatives are asked for."""

import dataclasses

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from t2l.detective.data_split import split
from t2l.detective.explanation import explained
from t2l.identify.model import Model
from t2l.sim.commands import Stamped
from tests.diagnose.made import pendulum, predict, recording, swing

TICK_S = 0.01
NOISE_RAD = 1e-3  # a command that misses its tick moves the pendulum by more


def stamped(rng, duration_s=2.0, **changes):
    """Commands of 40 Hz, each stamped somewhere between two ticks, and samples at ticks."""
    ticks = np.round(np.arange(0, duration_s, TICK_S), 6)
    stamps = np.round(np.arange(0.025, duration_s - 0.1, 0.025) + rng.uniform(0, 0.02), 6)
    stamps = np.round(stamps + rng.uniform(0, 0.5 * TICK_S, len(stamps)), 6)
    return rows_of(ticks, stamps, swing(0.5, 1.2)(stamps), **changes)


def rows_of(ticks, at_s, commands, robot, **changes):
    """A recording of commands from these times on, sampled at `ticks`."""
    time = np.union1d(ticks, at_s)
    row = np.searchsorted(at_s, time, side="right") - 1
    q_des = np.where(row < 0, 0.2, commands[np.maximum(row, 0)])[:, None]
    q = np.where(np.isin(time, ticks)[:, None], 0.2, np.nan)
    one = recording(robot, lambda t: np.full(len(t), 0.2), control_rate_hz=1 / TICK_S, **changes)
    return dataclasses.replace(one, time=time, q_des=q_des, q=q, command_rate_hz=40.0)


@given(st.integers(0, 1000), st.floats(0, 1.5))
def test_the_mean_over_a_tick_is_that_of_all_times_in_it(seed, at):
    rng = np.random.default_rng(seed)
    elapsed = np.r_[0, np.sort(rng.uniform(0, 1, 20))]
    some = Stamped.of(elapsed, {"commands": rng.normal(size=(21, 2))}, 0.05)
    fine = at + 0.05 * ((np.arange(4000) + 0.5) / 4000 - 0.5)
    # a jump falls into one of the parts
    every = some.at("commands", fine).mean(axis=0)
    assert some.mean("commands", np.array([at]))[0] == pytest.approx(every, abs=0.02)


@pytest.mark.parametrize("delay_s", [0.0031, 0.0127, 0.0342])
def test_a_late_command_is_in_force_from_the_first_tick_after_it_arrives(tmp_path, delay_s):
    robot, rng = pendulum(tmp_path), np.random.default_rng(0)
    sent = stamped(rng, robot=robot)
    new = np.r_[True, np.diff(sent.q_des[:, 0]) != 0]
    arrives = sent.time[new][1:] + delay_s
    ticks = sent.time[~np.isnan(sent.q[:, 0])]
    at_ticks = np.round(np.ceil(arrives / TICK_S - 1e-7) * TICK_S, 6)
    in_time = rows_of(ticks, at_ticks, sent.q_des[new, 0][1:], robot)
    late = predict(sent, {"command_delay": {"delay": delay_s}})
    assert np.abs(late - predict(in_time)).max() < 1e-9
    assert np.abs(late - predict(sent)).max() > 1e-3


def test_the_delay_of_commands_that_are_stamped_between_ticks_is_found(tmp_path):
    robot, rng = pendulum(tmp_path), np.random.default_rng(1)
    truth = Model(robot, {"command_delay": {"delay": 0.0263}})
    made = []
    for kp, kd in ((5.0, 0.3), (20.0, 0.8), (60.0, 1.5), (20.0, 0.8)):
        one = stamped(rng, robot=robot, kp=kp, kd=kd, name=f"kp{kp:g}_{len(made)}")
        q, sampled = one.q.copy(), ~np.isnan(one.q)
        q[sampled] = predict(one, model=truth) + NOISE_RAD * rng.normal(size=sampled.sum())
        made.append(dataclasses.replace(one, q=q))
    data = split(robot, made[:3], made[3:], threads=1)
    found = explained(Model(robot), data)
    assert list(found.model.effects) == ["command_delay"]
    delay = np.ravel(list(found.model.effects["command_delay"].values()))[0]
    assert delay == pytest.approx(0.0263, abs=0.1 * TICK_S)
    # some commands arrive a tick early or late, of those that miss one by nearly nothing
    first, last = (found.steps[i].test_rmse_rad for i in (0, -1))
    assert last < 0.03 * first
