"""Samples that fit a curve, samples that choose among curves, and fewer recordings of many."""

import numpy as np

from t2l.identify import block_bootstrap as judge
from t2l.identify.prediction import Predictor

BLOCK_S = 2 * judge.BLOCK_S  # derived: longer than a controlled joint remembers
CHOOSING = 3  # tuned: every third block


def split(predictor: Predictor) -> tuple[np.ndarray, np.ndarray]:
    """(nsample,) bool each: blocks of time that are fitted, and those that choose.

    They change places from recording to recording, so that each set sees all of the time.
    """
    samples = predictor.samples
    durations = np.array([r.duration_s for r in predictor.recordings])
    block = np.minimum(BLOCK_S, durations / 2 / CHOOSING)[samples.recording]
    number = np.floor(samples.time / block).astype(int)
    chooses = (number + samples.recording) % CHOOSING == CHOOSING - 1
    return ~chooses, chooses


def few(predictor: Predictor, count: int) -> tuple[Predictor, np.ndarray]:
    """A predictor of at most `count` recordings, spread over the gains; indices of its samples."""
    recordings = predictor.recordings
    if count >= len(recordings):
        return predictor, np.arange(len(predictor.samples))
    order = sorted(range(len(recordings)), key=lambda i: (*recordings[i].kp, *recordings[i].kd))
    places = np.round(np.linspace(0, len(order) - 1, count)).astype(int)
    taken = sorted(order[place] for place in places)
    part = predictor.of([recordings[i] for i in taken])
    return part, np.flatnonzero(np.isin(predictor.samples.recording, taken))
