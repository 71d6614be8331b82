from itertools import product

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from t2l.response.second_order import fit
from t2l.response.track import Track, respond
from tests.diagnose import made as plants
from tests.response.made import commands, rows


def test_the_response_is_that_of_an_integrator():
    time, command = commands(1.0)
    omega, zeta, delay = 15.0, 0.3, 0.013

    def change(t, state):
        late = command[max(0, int(np.floor((t - delay) * 50 + 1e-9)))]
        return state[1], omega**2 * (late - state[0]) - 2 * zeta * omega * state[1]

    exact = solve_ivp(change, (0, time[-1]), (0, 0), t_eval=time, max_step=1e-3, rtol=1e-9)
    # before the first command the system is taken to have had it: a step at the start
    forced = respond(Track.of(time, command, command), omega, zeta, delay)[0]
    assert np.abs(forced - exact.y[0]).max() < 3e-4


@pytest.mark.parametrize("zeta", [0.1, 0.9, 4.0])
def test_a_known_system_is_found_with_its_delay_and_gain(zeta):
    time, command, q = rows(18.0, zeta, 0.021, 0.9, 2e-4)
    found = fit([Track.of(time, command, q)])
    # the faster of two poles is seen for a sample or two
    assert found.omega == pytest.approx(18.0, rel=0.05 if zeta < 2 else 0.1)
    assert found.zeta == pytest.approx(zeta, rel=0.05 if zeta < 2 else 0.1)
    assert found.delay_s == pytest.approx(0.021, abs=2e-3)
    assert found.gain == pytest.approx(0.9, abs=0.01)
    assert found.explained > 0.999


def test_intervals_hold_the_truth_as_often_as_they_say():
    held = 0
    for seed in range(10):
        found = fit([Track.of(*rows(20.0, 0.5, noise=2e-3, seed=seed, duration_s=2.4))])
        held += all(
            low < truth < high
            for truth, (low, high) in ((20.0, found.interval(0)), (0.5, found.interval(1)))
        )
    assert held >= 7  # of 10 pairs of 95 % intervals: 9 are expected


def test_jittered_rows_and_gaps_change_little():
    time, command, q = rows(18.0, 0.5, noise=1e-4)
    rng = np.random.default_rng(0)
    q[rng.random(len(q)) < 0.3] = np.nan
    # the motion goes on while stamps wander and some rows are lost
    kept = rng.random(len(q)) > 0.05
    kept[:2] = True
    found = fit([Track.of(time[kept], command[kept], q[kept])])
    assert found.omega == pytest.approx(18.0, rel=0.1)
    wandering = time + rng.uniform(0, 0.1, len(time)) / 50
    found = fit([Track.of(wandering, command, q)])
    assert found.omega == pytest.approx(18.0, rel=0.1)


def test_a_joint_that_only_creeps_is_not_told_apart():
    time, command, q = rows(2000.0, 60.0, noise=1e-3)
    found = fit([Track.of(time, command, q)])
    assert not np.isfinite(found.interval(0)[1]) or found.interval(0)[1] > 3 * found.interval(0)[0]


def test_the_simulated_gains_of_sixteen_cells_are_found(tmp_path):
    robot, inertia = plants.spinner(tmp_path, 'armature="0.15" damping="0"'), 0.15 + plants.LINK
    cells = list(product((16.0, 64.0, 256.0, 512.0), (1.0, 4.0, 12.0, 24.0)))
    time, command = commands(3.01, 100.0)
    logs = [
        plants.recording(robot, lambda t: command[: len(t)], kp=kp, kd=kd, duration_s=3.0)
        for kp, kd in cells
    ]
    noise = 1e-4 * np.random.default_rng(0).normal(size=(len(cells), len(time)))
    for (kp, kd), q in zip(cells, plants.predict(logs).reshape(noise.shape) + noise, strict=True):
        found = fit([Track.of(time, command, q)])
        assert found.omega == pytest.approx(np.sqrt(kp / inertia), rel=0.1)
        # of a torque held for 1 ms, see t2l.sim.servo
        zeta = (kd - kp * 0.5e-3) / (2 * np.sqrt(kp * inertia))
        assert found.zeta == pytest.approx(zeta, rel=0.1)
