import numpy as np
import pytest

from t2l.identify.block_bootstrap import BLOCK_S, blocks, improvement

SAMPLES, BLOCKS = 50, 40
LABEL = np.repeat(np.arange(BLOCKS), SAMPLES)


def residuals(rng, size):
    """Errors whose size differs from block to block, as that of motions does."""
    loud = np.exp(0.3 * rng.normal(size=BLOCKS))[LABEL]
    return size * loud * rng.normal(size=len(LABEL))


def test_blocks_are_half_a_second_of_one_recording():
    recording = np.repeat([0, 1, 2], [300, 100, 7])
    time = np.concatenate([np.arange(n) / 100 for n in (300, 100, 7)])
    label = blocks(recording, time)
    assert set(label) == set(range(label.max() + 1))
    for block in range(label.max() + 1):
        assert len(set(recording[label == block])) == 1
        assert np.ptp(time[label == block]) < BLOCK_S
    assert label.max() + 1 == 6 + 2 + 1


def test_blocks_do_not_mind_an_order():
    recording, time = np.repeat([0, 1], 100), np.tile(np.arange(100) / 100, 2)
    shuffled = np.random.default_rng(0).permutation(200)
    label = blocks(recording, time)
    np.testing.assert_array_equal(blocks(recording[shuffled], time[shuffled]), label[shuffled])


def test_the_interval_covers_the_truth():
    truth, hit, below = 0.2, 0, 0
    for seed in range(150):
        rng = np.random.default_rng(seed)
        before = residuals(rng, 1.0)
        after = (1 - truth) * before * np.exp(0.1 * rng.normal(size=BLOCKS))[LABEL]
        found = improvement(before, after, LABEL)
        low, high = found.ci95
        assert low <= found.fraction <= high
        hit += low <= truth <= high
        below += found.lower > truth
    assert hit >= 130
    assert below <= 6


def test_chance_seldom_looks_like_an_improvement():
    """Two errors of the same size: the bound that decides stays below zero."""
    wins = 0
    for seed in range(150):
        rng = np.random.default_rng(seed)
        wins += improvement(residuals(rng, 1.0), residuals(rng, 1.0), LABEL).lower > 0
    assert wins <= 5


@pytest.mark.parametrize("size", [1.0, 0.0])
def test_the_same_error_is_no_improvement(size):
    same = residuals(np.random.default_rng(0), size)
    found = improvement(same, same, LABEL)
    assert found.fraction == found.lower == 0
    assert found.ci95 == (0, 0)


def test_a_worse_error_is_a_negative_improvement():
    before = residuals(np.random.default_rng(0), 1.0)
    found = improvement(before, 1.5 * before, LABEL)
    assert found.fraction == pytest.approx(-0.5)
    assert found.ci95[1] < 0
