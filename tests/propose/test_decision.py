"""When a known effect is named."""

import numpy as np
import pytest

from t2l.propose.decision import decide, each_goes_half_way


def test_an_effect_that_reaches_the_ceiling_is_named():
    assert decide(known=1.05e-4, ceiling=1e-4, baseline=3e-3, noise=9e-5).named


def test_an_effect_that_leaves_twice_the_noise_is_not_although_it_explains_most():
    found = decide(known=2.4e-4, ceiling=1.1e-4, baseline=1.13e-3, noise=1e-4)
    assert not found.named
    assert found.fraction == pytest.approx(0.96, abs=0.01)


def test_an_effect_is_named_where_no_law_does_better():
    assert decide(known=5e-4, ceiling=5e-4, baseline=1e-3, noise=1e-4).named


def test_what_lies_at_the_noise_is_named_whatever_a_curve_gains():
    assert decide(known=1.05e-4, ceiling=0.8e-4, baseline=1e-3, noise=1e-4).named


def test_the_part_is_of_the_squared_error():
    assert decide(known=0.8, ceiling=0.0, baseline=1.0, noise=0.0).fraction == pytest.approx(0.36)
    assert decide(known=1.0, ceiling=1.0, baseline=1.0, noise=0.1).fraction == 0.0


def test_an_error_that_is_none_is_refused():
    with pytest.raises(ValueError, match="ceiling"):
        decide(known=1.0, ceiling=float("nan"), baseline=1.0, noise=0.1)


@pytest.mark.parametrize("scale", [1.0, 1e-3])
def test_names_are_adopted_from_half_of_the_way_to_the_noise_in_orders_of_magnitude(scale):
    came, noise = 10.0 * scale, 0.1 * scale
    assert each_goes_half_way(1, 0.99 * scale, came, noise)
    assert not each_goes_half_way(1, 1.01 * scale, came, noise)
    halfway_of_the_rest = np.sqrt(scale * noise)
    assert each_goes_half_way(2, 0.99 * halfway_of_the_rest, came, noise)
    assert not each_goes_half_way(2, 1.01 * halfway_of_the_rest, came, noise)


def test_what_leaves_only_noise_is_adopted_however_small_it_was():
    assert each_goes_half_way(count=1, left=0.0, came=1.0, noise=0.0)
    assert each_goes_half_way(count=5, left=1.09, came=1.15, noise=1.0)
