import dataclasses

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from t2l.diagnose.evidence import fine_enough, gather, some
from t2l.identify.model import Model
from t2l.identify.prediction import Predictor
from t2l.identify.step_size import substeps_for
from tests.diagnose.made import pendulum, recording, swing, swings

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


def sets(evidence):
    """What was measured in each of the three sets."""
    return [
        moments(getattr(evidence, part), getattr(evidence, f"{part}_mask"))
        for part in ("train", "validation", "test")
    ]


@settings(deadline=None, max_examples=12)
@given(DURATIONS, st.integers(0, 3))
def test_no_sample_is_in_two_sets(robot, durations, given_held):
    recordings = made(robot, durations)
    held = recordings[:given_held] if given_held < len(recordings) else []
    evidence = gather(robot, recordings[len(held) :], held)
    train, validation, test = sets(evidence)
    assert min(map(len, (train, validation, test))) > 0
    assert not train & validation
    assert not (train | validation) & test
    assert moments(evidence.screen, evidence.screen_mask) <= train
    if held:
        assert {name for name, _ in test} == {r.name for r in held}


@pytest.mark.parametrize(("count", "chosen", "tested"), [(4, 0, 1), (5, 1, 1), (12, 2, 3)])
def test_whole_recordings_are_taken_where_there_are_enough(robot, count, chosen, tested):
    recordings = made(robot, [0.5] * count)
    evidence = gather(robot, recordings)
    train, validation, test = ({name for name, _ in part} for part in sets(evidence))
    assert len(test) == tested
    assert not test & (train | validation)
    assert len(validation - train) == chosen
    again = gather(robot, recordings[::-1])
    assert [{name for name, _ in part} for part in sets(again)] == [train, validation, test]


def test_what_is_given_to_hold_out_only_reports(robot):
    recordings = made(robot, [0.5] * 5)
    evidence = gather(robot, recordings[:3], recordings[3:4])
    assert names(evidence.train) == names(evidence.validation) == ["r0", "r1", "r2"]
    assert names(evidence.test) == ["r3"]
    assert evidence.test_mask.all()


@pytest.mark.parametrize("count", [1, 2])
def test_few_recordings_are_split_by_blocks_of_time_with_guards(robot, count):
    evidence = gather(robot, made(robot, [8.0] * count))
    assert evidence.split == "validation: blocks of time; test: blocks of time"
    assert evidence.train is evidence.validation is evidence.test
    samples = evidence.train.samples
    masks = evidence.train_mask, evidence.validation_mask, evidence.test_mask
    for i in range(count):
        of = samples.recording == i
        shares = [mask[of].mean() for mask in masks]
        assert shares == pytest.approx([0.46, 0.23, 0.23], abs=0.02)
        # in a few blocks, not sample by sample, and far from the samples of another set
        for mask in masks:
            assert np.abs(np.diff(mask[of].astype(int))).sum() <= 8
        times = [samples.time[of & mask] for mask in masks]
        for one, other in ((0, 1), (0, 2), (1, 2)):
            assert np.abs(times[one][:, None] - times[other]).min() > 0.09


def test_a_single_short_recording_can_be_split(robot):
    evidence = gather(robot, made(robot, [0.3]))
    assert all(map(len, sets(evidence)))


def test_many_recordings_are_screened_on_some_of_them(robot):
    recordings = made(robot, [0.5] * 20)
    evidence = gather(robot, recordings)
    assert set(names(evidence.screen)) < set(names(evidence.train))
    # both ends of the gains among them
    gains = sorted(r.kp[0] for r in evidence.train.recordings)
    assert {gains[0], gains[-1]} <= {r.kp[0] for r in evidence.screen.recordings}


def test_some_recordings_spread_over_their_order_with_their_part_of_the_mask(robot):
    predictor = Predictor(robot, made(robot, [0.5] * 14))
    mask = predictor.samples.time < 0.1 * (1 + predictor.samples.recording)
    part, part_mask = some(predictor, mask, 3)
    assert part.recordings == tuple(predictor.recordings[i] for i in (0, 6, 13))
    at = part_mask.nonzero()[0]
    whole = [6 * r if r < 2 else 13 for r in part.samples.recording[at]]
    assert (part.samples.time[at] < 0.1 * (1 + np.array(whole))).all()
    assert part_mask.sum() == mask[np.isin(predictor.samples.recording, (0, 6, 13))].sum()
    assert some(predictor, mask, 14) == (predictor, mask)


def test_an_effect_that_needs_finer_steps_gets_them(tmp_path):
    friction = {"coulomb_friction": {"torque": {"hinge": 0.05}}}
    robot = pendulum(tmp_path)
    recordings = swings(robot, friction, 1e-4, 0.5, control_rate_hz=125.0)
    fitted = gather(robot, recordings, threads=1).train.recordings
    few = substeps_for(Model(robot), fitted)
    evidence = gather(robot, recordings, substeps=few, threads=1)
    assert fine_enough(Model(robot), evidence) is evidence
    finer = fine_enough(Model(robot, friction), evidence)
    assert finer.train.substeps > evidence.train.substeps
    assert finer.validation.substeps == finer.test.substeps == finer.train.substeps
    assert (finer.validation is finer.train) == (evidence.validation is evidence.train)
    assert finer.train.recordings == evidence.train.recordings
    assert fine_enough(Model(robot, friction), finer) is finer


def test_all_recordings_say_whether_those_of_a_set_may_begin_in_motion(robot):
    recordings = made(robot, [1.0] * 5)
    for count, expected in ((0, False), (2, False), (3, True)):
        moving = [
            dataclasses.replace(r, dq=np.full_like(r.q, 0.5 * (i < count)))
            for i, r in enumerate(recordings)
        ]
        evidence = gather(robot, moving[2:], moving[:2])
        parts = evidence.train, evidence.validation, evidence.test, evidence.screen
        assert {each.in_motion for each in parts} == {expected}
        again = evidence.train.of(evidence.train.recordings[:1], coarseness=2)
        assert again.in_motion == expected
