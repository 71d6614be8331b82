"""Recordings that a model is fitted to, and those that report its error.

What is fitted is also what chooses, by cross-validation: each fold is left out in turn and judged
by a model that the others fitted. Folds are whole recordings; where several recordings share a pair
of gains, all of one pair, so that a term must help under gains that no fit has seen; and stretches
of time where there are fewer than three recordings. Test samples do neither.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from t2l.identify.block_bootstrap import BLOCK_S
from t2l.identify.initial_state import half_begin_in_motion
from t2l.identify.prediction import Predictor
from t2l.recordings.recording import Recording
from t2l.recordings.splits import LEAST_TO_HOLD_OUT_WHOLE, hold_out, time_blocks

TESTED = 0.25  # tuned: of the recordings that report: most are left to fit
MOST_FOLDS = 8  # numerics: more take longer and say the same
PIECES = 4  # numerics: folds of one recording
GUARD = 0.1  # tuned: of a block of time: residuals are alike over tens of milliseconds


@dataclass(frozen=True)
class DataSplit:
    """Samples to fit and choose by, and samples to report.

    Attributes:
        fitted, test: predictors; one and the same where blocks of time report.
        fitted_mask, test_mask: (nsample,) bool of each predictor's samples.
        folds: (nfitted,) number of the fold of each fitted sample.
        words: what the folds and the test samples are.
    """

    fitted: Predictor
    fitted_mask: np.ndarray
    test: Predictor
    test_mask: np.ndarray
    folds: np.ndarray
    words: str


def split(
    robot: str,
    recordings: Sequence[Recording],
    holdout: Sequence[Recording] = (),
    substeps: int = 1,
    threads: int | None = None,
) -> DataSplit:
    """`holdout`, or else whole recordings where there are three, or else blocks of time report."""
    rest, test = list(recordings), list(holdout)
    in_motion = half_begin_in_motion((*rest, *test))

    def predictor(of: Sequence[Recording]) -> Predictor:
        return Predictor(robot, of, substeps, threads, in_motion=in_motion)

    reports = "the recordings given"
    if not test and len(rest) >= LEAST_TO_HOLD_OUT_WHOLE:
        rest, test = hold_out(rest, TESTED, seed=0)
        reports = "whole recordings"
    fitted = predictor(rest)
    mask = np.ones(len(fitted.samples), bool)
    if test:
        tested = predictor(test)
        test_mask = np.ones(len(tested.samples), bool)
    else:
        tested, reports = fitted, "blocks of time"
        mask, test_mask = _by_blocks(fitted)
    folds, chooses = _folds(fitted, mask)
    return DataSplit(
        fitted, mask, tested, test_mask, folds, f"left out in turn: {chooses}; test: {reports}"
    )


def _by_blocks(predictor: Predictor) -> tuple[np.ndarray, np.ndarray]:
    """Every fourth block of time reports; samples beside an edge belong to neither."""
    samples = predictor.samples
    fitted, tested = np.zeros((2, len(samples)), bool)
    for i, recording in enumerate(predictor.recordings):
        block_s = min(2 * BLOCK_S, recording.duration_s / 8)
        at = np.flatnonzero(samples.recording == i)
        block = time_blocks(recording, block_s)[samples.row[at]]
        inside = (block == 0) | (samples.time[at] >= (block + GUARD) * block_s)
        fitted[at[inside & (block % 4 != 3)]] = True
        tested[at[inside & (block % 4 == 3)]] = True
    return fitted, tested


def _folds(predictor: Predictor, mask: np.ndarray) -> tuple[np.ndarray, str]:
    samples, recordings = predictor.samples, predictor.recordings
    recording = samples.recording[mask]
    gains = [(*r.kp, *r.kd) for r in recordings]
    distinct = sorted(set(gains))
    if len(recordings) < LEAST_TO_HOLD_OUT_WHOLE:
        length = np.array([r.duration_s for r in recordings])[recording]
        piece = np.minimum((samples.time[mask] / length * PIECES).astype(int), PIECES - 1)
        return recording * PIECES + piece, "stretches of time"
    if LEAST_TO_HOLD_OUT_WHOLE <= len(distinct) < len(recordings):
        group, words = [distinct.index(g) for g in gains], "all recordings of a pair of gains"
    else:
        group, words = [*range(len(recordings))], "whole recordings"
    of = np.array(group) % MOST_FOLDS if max(group) >= MOST_FOLDS else np.array(group)
    return of[recording], words
