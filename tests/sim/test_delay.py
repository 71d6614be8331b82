import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from t2l.sim.delay import DelayLine


@pytest.mark.parametrize("ticks", [0.0, 0.25, 1.0, 2.5])
def test_a_ramp_comes_late_by_the_delay(ticks):
    line = DelayLine(np.full((2, 1), ticks))
    for tick in range(10):
        found = line(np.array([[tick, 10 * tick], [0.0, -tick]]))
        late = max(tick - ticks, 0.0)
        np.testing.assert_allclose(found, [[late, 10 * late], [0.0, -late]], atol=1e-12)


def test_each_row_has_a_delay_of_its_own():
    line = DelayLine(np.array([[0.0], [3.0]]))
    found = [line(np.full((2, 1), float(tick)))[:, 0].tolist() for tick in range(6)]
    assert found == [[0, 0], [1, 0], [2, 0], [3, 0], [4, 1], [5, 2]]


@given(
    ticks=st.lists(st.floats(0.0, 6.0), min_size=2, max_size=2),
    lengths=st.lists(st.integers(1, 5), min_size=1, max_size=6),
)
def test_ticks_that_come_together_are_late_like_ticks_that_come_in_turn(ticks, lengths):
    ticks = np.array(ticks)[:, None]
    signal = np.random.default_rng(0).normal(size=(sum(lengths), 2, 3))
    in_turn, together = DelayLine(ticks), DelayLine(ticks)
    expected = np.array([in_turn(one) for one in signal])
    parts = np.split(signal, np.cumsum(lengths)[:-1])
    found = np.concatenate([together(part) for part in parts])
    np.testing.assert_array_equal(found, expected)
