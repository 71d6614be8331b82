"""Recordings that a model is fitted to, and those that report its error.

What is fitted is also what chooses, by cross-validation: each fold is left out in turn and judged
by a model that the others fitted. Folds are whole recordings. Where several share a pair of gains,
all of one pair are left out together, so that a term must help under gains that no fit has seen;
where several share a motion, all of one motion likewise. Where both are so, each recording is left
out twice. Folds are stretches of time where there is one recording. Test samples do neither.
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
# numerics: of what commands ask for and of a length, by which recordings of one motion may differ
SAME_MOTION = 0.1
INSTANTS = 1000  # numerics: at which commands are compared
TURNS = ("fitted", "fitted", "fitted", "test")  # whose a block of time is, in turn


@dataclass(frozen=True)
class DataSplit:
    """Samples to fit and choose by, and samples to report.

    Attributes:
        fitted, test: predictors; one and the same where blocks of time report.
        fitted_mask, test_mask: (nsample,) bool of each predictor's samples.
        folds: (nfitted, k) numbers of the folds of each fitted sample, for k ways to leave it out;
            each way has numbers of its own.
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
    if len(recordings) == 1:
        length = np.array([r.duration_s for r in recordings])[recording]
        piece = np.minimum((samples.time[mask] / length * PIECES).astype(int), PIECES - 1)
        return piece[:, None]
    every = np.arange(len(recordings))
    ways = [
        of for of in (by_gains(recordings), by_motion(recordings))
        if LEAST_TO_HOLD_OUT_WHOLE <= of.max() + 1 < len(recordings)
    ]  # fmt: skip
    folds = [of % MOST_FOLDS + MOST_FOLDS * i for i, of in enumerate(ways or [every])]
    return np.stack(folds, axis=-1)[recording]


def by_gains(recordings: Sequence[Recording]) -> np.ndarray:
    """(nrec,) number of each recording's pair of gains."""
    gains = [(*r.kp, *r.kd) for r in recordings]
    distinct = sorted(set(gains))
    return np.array([distinct.index(g) for g in gains])


def by_motion(recordings: Sequence[Recording]) -> np.ndarray:
    """(nrec,) number of each recording's motion: commands that hardly differ ask for the same."""
    found: list[Recording] = []
    number = []
    for recording in recordings:
        same = (i for i, one in enumerate(found) if _one_motion(one, recording))
        number.append(next(same, len(found)))
        if number[-1] == len(found):
            found.append(recording)
    return np.array(number)


def _one_motion(one: Recording, other: Recording) -> bool:
    shorter, longer = sorted((one.duration_s, other.duration_s))
    if shorter < (1 - SAME_MOTION) * longer:
        return False
    at = np.linspace(0, shorter, INSTANTS)
    a, b = (_commanded(recording, at) for recording in (one, other))
    size = min(np.sqrt(np.mean((v - v.mean(axis=0)) ** 2)) for v in (a, b))
    return bool(np.sqrt(np.mean((a - b) ** 2)) <= SAME_MOTION * size)


def _commanded(recording: Recording, at: np.ndarray) -> np.ndarray:
    """q_des (k, njoint) at some times since the start, rad."""
    row = np.searchsorted(recording.time - recording.time[0], at, side="right") - 1
    return recording.q_des[np.maximum(row, 0)]
