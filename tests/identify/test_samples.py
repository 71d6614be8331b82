import dataclasses

import numpy as np

from t2l.identify.samples import Samples
from tests.diagnose.made import (
    pendulum,
    recording,
    swing,
)


def test_samples_tell_where_each_was_measured(tmp_path):
    robot = pendulum(tmp_path)
    first = recording(robot, swing(), "first", duration_s=0.5)
    gaps = np.where(np.arange(len(first.time))[:, None] % 4 == 1, np.nan, first.q)
    gaps[0] = first.q[0]
    second = dataclasses.replace(first, q=gaps, time=first.time + 17.0)
    samples = Samples.measured([first, second])
    assert len(samples) == len(first.time) + np.isfinite(gaps).sum()
    in_second = samples.recording == 1
    np.testing.assert_allclose(samples.time[in_second], first.time[samples.row[in_second]])
    np.testing.assert_array_equal(samples.q[in_second], gaps[np.isfinite(gaps)])
    np.testing.assert_array_equal(
        samples.of([first.q_des, 2 * second.q_des])[in_second],
        2 * second.q_des[samples.row[in_second], 0],
    )
    for signal, made in zip(samples.by_row(samples.q), (first, second), strict=True):
        np.testing.assert_array_equal(signal, made.q)
