"""Recordings to fit and recordings to judge by."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from t2l.discrepancy.prediction import Predictor
from t2l.measurements.recording import Recording
from t2l.measurements.splits import hold_out, time_blocks

HOLDOUT_FRACTION = 0.3
SCREENED = (2, 5)  # fewest and most recordings that every effect is tried on


@dataclass(frozen=True)
class Evidence:
    """Samples to fit, samples to judge by, and fewer of the first to try everything on.

    Attributes:
        train, holdout, screen: predictors; one and the same where blocks of time are held out.
        train_mask, holdout_mask, screen_mask: (nsample,) bool of each predictor's samples.
    """

    train: Predictor
    train_mask: np.ndarray
    holdout: Predictor
    holdout_mask: np.ndarray
    screen: Predictor
    screen_mask: np.ndarray
    split: str


def gather(
    robot: str,
    recordings: Sequence[Recording],
    holdout: Sequence[Recording] = (),
    substeps: int = 1,
    threads: int | None = None,
) -> Evidence:
    """Split what was recorded: as given, by whole recordings, or one recording by time."""
    recordings = list(recordings)
    held = list(holdout)
    split = "the recordings given"
    if not held and len(recordings) >= 3:
        recordings, held = hold_out(recordings, HOLDOUT_FRACTION, seed=0)
        split = "whole recordings"
    if not held:
        return by_blocks(robot, recordings, substeps, threads)
    train = Predictor(robot, recordings, substeps, threads)
    test = Predictor(robot, held, substeps, threads)
    few = _spread(recordings)
    screen = train if len(few) == len(recordings) else Predictor(robot, few, substeps, threads)
    return Evidence(train, _all(train), test, _all(test), screen, _all(screen), split)


def by_blocks(
    robot: str, recordings: Sequence[Recording], substeps: int = 1, threads: int | None = None
) -> Evidence:
    """Hold out every other block of time of each recording, of a second or a quarter of it."""
    predictor = Predictor(robot, recordings, substeps, threads)
    held = np.zeros(len(predictor.samples), bool)
    for i, recording in enumerate(recordings):
        at = predictor.samples.recording == i
        block = time_blocks(recording, min(1.0, recording.duration_s / 4))
        held[at] = block[predictor.samples.row[at]] % 2 == 1
    return Evidence(predictor, ~held, predictor, held, predictor, ~held, "blocks of time")


def pooled(evidence: Evidence) -> Evidence:
    """All recordings together, judged by blocks of time."""
    train, holdout = evidence.train, evidence.holdout
    return by_blocks(
        train.robot, [*train.recordings, *holdout.recordings], train.substeps, train.threads
    )


def _all(predictor: Predictor) -> np.ndarray:
    return np.ones(len(predictor.samples), bool)


def _spread(recordings: list[Recording]) -> list[Recording]:
    """A few recordings spread over the gains, on which every effect is tried first."""
    count = int(np.clip(1 + np.ceil(len(recordings) / 8), *SCREENED))
    if count >= len(recordings):
        return recordings
    order = sorted(range(len(recordings)), key=lambda i: (*recordings[i].kp, *recordings[i].kd))
    chosen = np.round(np.linspace(0, len(order) - 1, count)).astype(int)
    return [recordings[order[i]] for i in chosen]
