"""Recordings that laws are learned from: samples that fit, and samples that choose."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from t2l.diagnose.judging import rms
from t2l.identify.block_bootstrap import blocks
from t2l.identify.prediction import Predictor, Request
from t2l.propose.refit import State
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
    others: tuple[Recording, ...] = ()

    @cached_property
    def block(self) -> np.ndarray:
        """The block of time of each choosing sample."""
        samples = self.predictor.samples
        return blocks(samples.recording[self.chosen], samples.time[self.chosen])

    def left_by(self, states: list[State]) -> tuple[list[np.ndarray], list[float]]:
        """Residuals (nsample,) of states, and their RMS on the choosing samples, rad.

        The RMS is infinite where a simulation runs away.
        """
        requests = [Request(s.layout, s.u[None]) for s in states]
        residuals = [self.predictor.samples.q - q[0] for q in self.predictor.predict(requests)]
        return residuals, [rms(np.nan_to_num(r[self.chosen], nan=np.inf)) for r in residuals]
