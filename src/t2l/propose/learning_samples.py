"""Recordings that laws are learned from: samples that fit, and samples that choose."""

from dataclasses import dataclass

import numpy as np

from t2l.diagnose.judging import rms
from t2l.identify.model import Model
from t2l.identify.prediction import Predictor, Request
from t2l.propose.found import Search
from t2l.propose.refit import State
from t2l.propose.search import MOST_LAWS, Progress, search
from t2l.recordings.recording import Recording


@dataclass(frozen=True)
class LearningSamples:
    """What laws are learned from.

    Attributes:
        fitted, chosen: (nsample,) bool of the samples to fit, and to choose by.
        others: recordings that the laws must also predict.
    """

    predictor: Predictor
    fitted: np.ndarray
    chosen: np.ndarray
    others: tuple[Recording, ...]

    def search(self, model: Model, progress: Progress, most: int = MOST_LAWS) -> Search:
        """Laws beside a model."""
        return search(model, self.predictor, self.fitted, self.chosen, progress, most, self.others)

    def residual(self, state: State) -> np.ndarray:
        """Measured minus predicted on the choosing samples, rad."""
        q = self.predictor.predict([Request(state.layout, state.u[None])])[0][0]
        return (self.predictor.samples.q - q)[self.chosen]

    def error(self, state: State) -> float:
        """RMS error in rad on the choosing samples; infinite where the simulation runs away."""
        error = rms(self.residual(state))
        return error if np.isfinite(error) else np.inf
