import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from t2l.diagnose.evidence import gather, some
from tests.diagnose.made import pendulum, recording, swing

DURATIONS = st.lists(st.floats(0.3, 6.0), min_size=1, max_size=8)


@pytest.fixture(scope="module")
def robot(tmp_path_factory):
    return pendulum(tmp_path_factory.mktemp("robot"))


def made(robot, durations, **changes):
    return [
        recording(robot, swing(), f"r{i}", kp=10.0 * (i + 1), duration_s=d, **changes)
        for i, d in enumerate(durations)
    ]


def names(predictor):
    return [r.name for r in predictor.recordings]


def moments(predictor, mask):
    """What was measured in the masked samples, by recording and time."""
    samples = predictor.samples
    return {
        (predictor.recordings[r].name, t)
        for r, t in zip(samples.recording[mask], samples.time[mask], strict=True)
    }


@settings(deadline=None, max_examples=20)
@given(DURATIONS, st.integers(0, 3))
def test_nothing_is_both_fitted_and_held_out(robot, durations, given_held):
    recordings = made(robot, durations)
    held = recordings[:given_held] if given_held < len(recordings) else []
    rest = recordings[len(held) :]
    evidence = gather(robot, rest, held)
    train = moments(evidence.train, evidence.train_mask)
    test = moments(evidence.holdout, evidence.holdout_mask)
    assert train
    assert test
    assert not train & test
    assert moments(evidence.screen, evidence.screen_mask) <= train
    # and nothing is left out
    everything = gather(robot, recordings[:1], recordings[1:]) if recordings[1:] else evidence
    whole = moments(everything.train, everything.train_mask) | moments(
        everything.holdout, everything.holdout_mask
    )
    assert train | test == whole


def test_whole_recordings_are_held_out_of_three_or_more(robot):
    recordings = made(robot, [0.5] * 7)
    evidence = gather(robot, recordings)
    assert evidence.split == "whole recordings"
    train, held = names(evidence.train), names(evidence.holdout)
    assert sorted(train + held) == [r.name for r in recordings]
    assert 1 <= len(held) <= 3
    assert evidence.train_mask.all()
    assert evidence.holdout_mask.all()
    again = gather(robot, recordings[::-1])
    assert sorted(names(again.holdout)) == sorted(held)


def test_what_is_given_to_hold_out_is_held_out(robot):
    recordings = made(robot, [0.5] * 5)
    evidence = gather(robot, recordings[:4], recordings[4:])
    assert names(evidence.train) == ["r0", "r1", "r2", "r3"]
    assert names(evidence.holdout) == ["r4"]


@pytest.mark.parametrize("count", [1, 2])
def test_few_recordings_are_split_by_blocks_of_time(robot, count):
    evidence = gather(robot, made(robot, [4.0] * count))
    assert evidence.split == "blocks of time"
    assert evidence.train is evidence.holdout
    np.testing.assert_array_equal(evidence.train_mask, ~evidence.holdout_mask)
    samples = evidence.train.samples
    for i in range(count):
        held = evidence.holdout_mask[samples.recording == i]
        assert 0.4 < held.mean() < 0.6
        # in a few blocks, not sample by sample
        assert np.abs(np.diff(held.astype(int))).sum() <= 4


def test_a_single_short_recording_can_be_split(robot):
    evidence = gather(robot, made(robot, [0.3]))
    assert 0.3 < evidence.holdout_mask.mean() < 0.7


def test_many_recordings_are_screened_on_some_of_them(robot):
    recordings = made(robot, [0.5] * 20)
    evidence = gather(robot, recordings)
    assert set(names(evidence.screen)) < set(names(evidence.train))
    # both ends of the gains among them
    gains = sorted(r.kp[0] for r in evidence.train.recordings)
    assert {gains[0], gains[-1]} <= {r.kp[0] for r in evidence.screen.recordings}


def test_some_recordings_spread_over_their_order_with_their_part_of_the_mask(robot):
    predictor = gather(robot, made(robot, [0.5] * 20)).train
    mask = predictor.samples.time < 0.1 * (1 + predictor.samples.recording)
    part, part_mask = some(predictor, mask, 3)
    assert part.recordings == tuple(predictor.recordings[i] for i in (0, 6, 13))
    at = part_mask.nonzero()[0]
    whole = [6 * r if r < 2 else 13 for r in part.samples.recording[at]]
    assert (part.samples.time[at] < 0.1 * (1 + np.array(whole))).all()
    assert part_mask.sum() == mask[np.isin(predictor.samples.recording, (0, 6, 13))].sum()
    assert some(predictor, mask, 14) == (predictor, mask)
