import dataclasses

import numpy as np
import pytest

from t2l.recordings import contradictions
from tests.recordings.made import recording

NOISE_RAD = 5e-4


def noisy(made, seed):
    noise = np.random.default_rng(seed).normal(scale=NOISE_RAD, size=made.q.shape)
    return dataclasses.replace(made, q=made.q + noise)


def test_repetitions_up_to_noise_agree():
    runs = [noisy(recording(name=f"r{i}", duration_s=8.0), seed=i) for i in range(6)]
    assert contradictions(runs, NOISE_RAD) == []


def test_another_response_is_named_with_joint_time_and_size():
    first, second = recording(name="first", duration_s=3.0), recording(name="second")
    q = recording(duration_s=4.0).q.copy()
    q[52:, 1] += 0.02
    second = recording(name="second", duration_s=4.0, q=q)
    (found,) = contradictions([noisy(first, 0), noisy(second, 1)], NOISE_RAD)
    assert (found.first, found.second, found.joint) == ("first", "second", "b")
    assert found.from_s == pytest.approx(1.04)
    assert found.rms_rad == pytest.approx(0.02 * np.sqrt(49 / 75), rel=0.1)
    assert "b moves differently from 1.04 s on (RMS difference 0.016 rad)" in found.message


@pytest.mark.parametrize(
    "change",
    [
        {"kp": np.full(2, 65.0)},
        {"command_rate_hz": 25.0},
        {"gravity_compensation": False},
        {"q_des": recording().q_des + 1e-4},
        {"q": recording().q + 0.05},
    ],
    ids=str,
)
def test_other_experiments_do_not_contradict(change):
    slower = dataclasses.replace(recording(lag_s=0.2), **change)
    assert contradictions([recording(), slower], NOISE_RAD) == []
    assert len(contradictions([recording(), recording(lag_s=0.2)], NOISE_RAD)) == 1


def test_clocks_may_start_elsewhere_jitter_and_tick_twice_as_fast():
    made = recording(duration_s=2.0)
    jitter = np.random.default_rng(0).uniform(0, 1e-3, len(made.time))
    assert (
        contradictions([made, dataclasses.replace(made, time=made.time + 5 + jitter)], 1e-3) == []
    )
    fast = dataclasses.replace(
        made,
        time=np.arange(200) / 100,
        q_des=np.repeat(made.q_des, 2, axis=0),
        q=np.repeat(recording(lag_s=0.3, duration_s=2.0).q, 2, axis=0),
    )
    assert len(contradictions([made, fast], NOISE_RAD)) == 1
