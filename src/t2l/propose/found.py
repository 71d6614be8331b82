"""What a search for laws has found so far, and when a law earns its place."""

from dataclasses import dataclass, field

import numpy as np

from t2l.effects.law import Law
from t2l.effects.spline_torque import SplineTorque
from t2l.identify.block_bootstrap import Improvement, improvement
from t2l.identify.levels import AT_THE_FLOOR, TIED
from t2l.identify.noise_floor import noise_floor
from t2l.identify.prediction import Predictor
from t2l.propose.learning_samples import LearningSamples
from t2l.propose.refit import State

LEAST_IMPROVEMENT = 1 - 1 / AT_THE_FLOOR  # derived: with less the model without it is as near
ALIKE = TIED  # of the error between laws that explain alike
SEED = 0  # statistics: of the bootstrap


@dataclass(frozen=True)
class Ceiling:
    """What one law alone can explain.

    Attributes:
        rmse_rad: on the choosing samples.
        simulated: whether the curve was simulated, or its response taken as linear.
    """

    law: Law
    rmse_rad: float
    simulated: bool


@dataclass
class Search:
    """What was found.

    Attributes:
        state: the model's effects with the laws that were taken.
        baseline_rad, rmse_rad: on the choosing samples, of the model and with the laws.
        noise_floor_rad: on all samples.
        ceilings: of every law beside the model, in the first round.
        residual: (nsample,) measured minus predicted, with the laws.
    """

    state: State
    baseline_rad: float
    rmse_rad: float
    noise_floor_rad: float
    residual: np.ndarray
    ceilings: list[Ceiling] = field(default_factory=list)

    @property
    def laws(self) -> list[SplineTorque]:
        """That were taken, in their order."""
        return [effect for effect, _ in self.state.laws]

    @property
    def left_more_than_noise(self) -> bool:
        """Whether the laws leave more than noise."""
        return self.rmse_rad > AT_THE_FLOOR * self.noise_floor_rad

    def is_material(self, left_rad: float) -> bool:
        """Whether a law is worth taking that leaves `left_rad`: it takes away more than noise."""
        return self.rmse_rad**2 - left_rad**2 >= self.noise_floor_rad**2

    def put(self, predictor: Predictor, state: State, residual: np.ndarray, error: float) -> None:
        """Go on from a state that leaves `residual` (nsample,) and `error`, both rad."""
        self.state, self.residual, self.rmse_rad = state, residual, error
        rows = predictor.samples.by_row(residual)
        floor = noise_floor(list(predictor.recordings), rows)
        self.noise_floor_rad = min(self.noise_floor_rad, floor)


def earns_its_place(before: np.ndarray, after: np.ndarray, samples: LearningSamples) -> bool:
    """Whether residuals (nsample,) fall from `before` to `after`, by enough and by no chance."""
    gain = _gain(before, after, samples)
    return gain.lower > 0 and gain.fraction >= LEAST_IMPROVEMENT


def explain_alike(simple: np.ndarray, other: np.ndarray, samples: LearningSamples) -> bool:
    """Whether `other` leaves no less than what is simpler leaves, residuals (nsample,)."""
    gain = _gain(simple, other, samples)
    return gain.lower <= 0 or gain.fraction <= ALIKE


def _gain(before: np.ndarray, after: np.ndarray, samples: LearningSamples) -> Improvement:
    left = (residual[samples.chosen] for residual in (before, after))
    return improvement(*left, samples.block, np.random.default_rng(SEED))
