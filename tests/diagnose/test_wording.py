"""Sentences about what an effect does to the error."""

import pytest

from t2l.diagnose.wording import change
from t2l.identify.block_bootstrap import Improvement


@pytest.mark.parametrize(
    ("fraction", "interval", "words"),
    [
        (0.26, (0.02, 0.5), "falls by 26 % (2 to 50 %), too unsure to be adopted"),
        (0.01, (-0.02, 0.03), "falls by 1 % (−2 to 3 %)"),
        (-0.2, (-0.4, -0.1), "grows by 20 % (10 to 40 %)"),
        (-0.2, (-0.4, 0.1), "grows by 20 % (−10 to 40 %)"),
    ],
)
def test_a_change_is_told_with_its_direction_and_its_interval(fraction, interval, words):
    assert change(Improvement(fraction, interval, lower=-1.0)) == words
