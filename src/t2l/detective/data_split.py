"""Recordings that a model is fitted to, and those that report its error.

What is fitted is also what chooses, by cross-validation: each fold is left out in turn and judged
by a model that the others fitted. Folds are whole recordings; where several recordings share a pair
of gains, all of one pair, so that a term must help under gains that no fit has seen; and stretches
of time where there is one recording. Test samples do neither.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from t2l.diagnose.settings import FRACTION, GUARD
from t2l.identify.block_bootstrap import BLOCK_S
from t2l.identify.initial_state import half_begin_in_motion
from t2l.identify.prediction import Predictor
from t2l.recordings.recording import Recording
from t2l.recordings.splits import LEAST_TO_HOLD_OUT_WHOLE, hold_out, time_blocks

MOST_FOLDS = 8  # numerics: more take longer and say the same
PIECES = 4  # numerics: folds of one recording
TURNS = ("fitted", "fitted", "fitted", "test")  # whose a block of time is, in turn


@dataclass(frozen=True)
class DataSplit:
    """Samples to fit and choose by, and samples to report.

    Attributes:
        fitted, test: predictors; one and the same where blocks of time report.
        fitted_mask, test_mask: (nsample,) bool of each predictor's samples.
        folds: (nfitted,) number of the fold of each fitted sample.
    """

    fitted: Predictor
    fitted_mask: np.ndarray
    test: Predictor
    test_mask: np.ndarray
    folds: np.ndarray


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

    if not test and len(rest) >= LEAST_TO_HOLD_OUT_WHOLE:
        rest, test = hold_out(rest, FRACTION, seed=0)
    fitted = predictor(rest)
    mask = np.ones(len(fitted.samples), bool)
    if test:
        tested = predictor(test)
        test_mask = np.ones(len(tested.samples), bool)
    else:
        tested = fitted
        mask, test_mask = by_time(fitted)
    return DataSplit(fitted, mask, tested, test_mask, _folds(fitted, mask))


def by_time(predictor: Predictor) -> tuple[np.ndarray, np.ndarray]:
    """Masks (nsample,) of samples to fit and to report: blocks of time, with a guard at each edge.

    Residuals are alike over a short time, so that samples beside an edge belong to neither.
    """
    turns, samples = np.array(TURNS), predictor.samples
    of = np.full(len(samples), "guard", turns.dtype)
    for i, recording in enumerate(predictor.recordings):
        block_s = min(2 * BLOCK_S, recording.duration_s / (2 * len(turns)))
        at = np.flatnonzero(samples.recording == i)
        block = time_blocks(recording, block_s)[samples.row[at]]
        inside = (block == 0) | (samples.time[at] >= (block + GUARD) * block_s)
        of[at[inside]] = turns[block[inside] % len(turns)]
    if not set(turns) <= set(of):  # sampled too rarely for blocks
        of = turns[samples.row % len(turns)]
    return of == "fitted", of == "test"


def _folds(predictor: Predictor, mask: np.ndarray) -> np.ndarray:
    samples, recordings = predictor.samples, predictor.recordings
    recording = samples.recording[mask]
    gains = [(*r.kp, *r.kd) for r in recordings]
    distinct = sorted(set(gains))
    if len(recordings) == 1:
        length = np.array([r.duration_s for r in recordings])[recording]
        piece = np.minimum((samples.time[mask] / length * PIECES).astype(int), PIECES - 1)
        return recording * PIECES + piece
    if LEAST_TO_HOLD_OUT_WHOLE <= len(distinct) < len(recordings):
        group = np.array([distinct.index(g) for g in gains])
    else:
        group = np.arange(len(recordings))
    return (group % MOST_FOLDS)[recording]
