import numpy as np
import pytest

from t2l.errors import RecordingError
from t2l.recordings import hold_out, time_blocks
from tests.recordings.made import recording

GRID = [
    recording(name=f"kp{kp}_kd{kd}", kp=kp, kd=kd)
    for kp in (16, 32, 64, 128, 256)
    for kd in (1, 2, 4, 8, 16)
]


@pytest.mark.parametrize("seed", range(5))
def test_held_out_recordings_are_spread_over_stiffness(seed):
    kept, held = hold_out(GRID, 0.2, seed)
    assert sorted({r.kp[0] for r in held}) == [16, 32, 64, 128, 256]
    assert len(kept) == 20
    assert {r.name for r in kept} | {r.name for r in held} == {r.name for r in GRID}


def test_a_split_depends_on_the_seed_and_not_on_the_order():
    def held(recordings, seed):
        return {r.name for r in hold_out(recordings, 0.3, seed)[1]}

    assert held(GRID, 1) == held(GRID[::-1], 1)
    assert held(GRID, 1) != held(GRID, 2)


@pytest.mark.parametrize("fraction", [0.01, 0.5, 0.99])
def test_there_is_always_something_on_either_side(fraction):
    kept, held = hold_out(GRID[:3], fraction, 0)
    assert kept
    assert held


def test_impossible_splits_are_refused():
    with pytest.raises(ValueError, match="2 recordings"):
        hold_out(GRID[:2], 0.5, 0)
    with pytest.raises(ValueError, match="found 1"):
        hold_out(GRID, 1, 0)


def test_blocks_of_time_alternate():
    blocks = time_blocks(recording(duration_s=4.0), block_s=0.5)
    assert blocks.tolist() == np.repeat(range(8), 25).tolist()


@pytest.mark.parametrize("block_s", [0, 3.0])
def test_blocks_that_leave_nothing_to_hold_out_are_refused(block_s):
    with pytest.raises(RecordingError, match=r"allowed: above 0, up to 1.99 s"):
        time_blocks(recording(duration_s=4.0), block_s)
