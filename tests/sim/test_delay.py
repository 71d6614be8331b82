import numpy as np
import pytest

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
