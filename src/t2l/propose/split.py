"""Samples that fit a curve and samples that choose among curves."""

import numpy as np

from t2l.identify.prediction import Predictor

BLOCK_S = 1.0  # longer than a controlled joint remembers
CHOOSING = 3  # every third block


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
