"""Recordings to fit and recordings to judge by."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from t2l.identify.prediction import Predictor
from t2l.recordings.recording import Recording
from t2l.recordings.splits import hold_out, time_blocks

HOLDOUT_FRACTION = 0.3
SCREENED = (2, 3)  # recordings that every effect is tried on; the more where there are many
MANY = 9  # recordings
SHORTLISTED = 12  # recordings that the likeliest effects are fitted on before they are judged


@dataclass(frozen=True)
class Evidence:
    """Samples to fit, samples to judge by, and fewer of the first to try everything on.

    Attributes:
        train, holdout: predictors; one and the same where blocks of time are held out.
        shortlist, screen: predictors of some of the training recordings, or of all if few.
        draft: predictor of all training recordings for all but the last steps of a fit to them.
        holdout_draft: predictor of the held-out ones for what was not fitted to all recordings.
        train_mask, …: (nsample,) bool of each predictor's samples.
    """

    train: Predictor
    train_mask: np.ndarray
    holdout: Predictor
    holdout_mask: np.ndarray
    shortlist: Predictor
    shortlist_mask: np.ndarray
    screen: Predictor
    screen_mask: np.ndarray
    draft: Predictor
    holdout_draft: Predictor
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
    mask = _all(train)
    return Evidence(
        train, mask, test, _all(test), *_over_the_gains(train, mask, SHORTLISTED),
        *_screened(train, mask), train, test, split,
    )  # fmt: skip


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
    return Evidence(
        predictor, ~held, predictor, held, *_over_the_gains(predictor, ~held, SHORTLISTED),
        *_screened(predictor, ~held), predictor, predictor, "blocks of time",
    )  # fmt: skip


def pooled(evidence: Evidence) -> Evidence:
    """All recordings together, judged by blocks of time."""
    train, holdout = evidence.train, evidence.holdout
    return by_blocks(
        train.robot, [*train.recordings, *holdout.recordings], train.substeps, train.threads
    )


def some(predictor: Predictor, mask: np.ndarray, count: int) -> tuple[Predictor, np.ndarray]:
    """A predictor of `count` of the recordings, spread over their order, and its part of `mask`."""
    return _part(predictor, mask, np.arange(len(predictor.recordings)), count)


def _screened(predictor: Predictor, mask: np.ndarray) -> tuple[Predictor, np.ndarray]:
    many = len(predictor.recordings) >= MANY
    return _over_the_gains(predictor, mask, SCREENED[many])


def _over_the_gains(
    predictor: Predictor, mask: np.ndarray, count: int
) -> tuple[Predictor, np.ndarray]:
    recordings = predictor.recordings
    order = sorted(range(len(recordings)), key=lambda i: (*recordings[i].kp, *recordings[i].kd))
    return _part(predictor, mask, np.array(order), count)


def _part(
    predictor: Predictor, mask: np.ndarray, order: np.ndarray, count: int
) -> tuple[Predictor, np.ndarray]:
    if count >= len(order):
        return predictor, mask
    chosen = np.sort(order[np.round(np.linspace(0, len(order) - 1, count)).astype(int)])
    part = predictor.of([predictor.recordings[i] for i in chosen])
    return part, mask[np.isin(predictor.samples.recording, chosen)]


def _all(predictor: Predictor) -> np.ndarray:
    return np.ones(len(predictor.samples), bool)
