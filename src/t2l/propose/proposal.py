"""What a model lacks, proposed as learned curves, and judged on data that made none of them."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from t2l.effects.law import Curve, Law
from t2l.identify.model import Model
from t2l.identify.prediction import Predictor, Request

LAW, NOTHING, NO_LAW = "law", "nothing_to_explain", "no_law"


@dataclass(frozen=True)
class Ceiling:
    """What one law alone can explain, by the linear model of the loop: RMS error in rad."""

    law: Law
    rmse_rad: float


@dataclass(frozen=True)
class Learned:
    """A curve with its band.

    Attributes:
        low, high: (n,) ends of the 95 % interval at each value of the curve.
        seen: the variable's ends in all recordings that formulas are simulated on; None for no
            further than `Curve.reach`.
    """

    curve: Curve
    low: np.ndarray
    high: np.ndarray
    seen: tuple[float, float] | None = None

    @property
    def reach(self) -> tuple[float, float]:
        """Ends of what a formula in the place of the curve must say."""
        ends = np.array([self.curve.reach, self.seen or self.curve.reach])
        return float(ends.min()), float(ends.max())


@dataclass(frozen=True)
class Proposal:
    """What was found.

    Attributes:
        verdict: `law`, `nothing_to_explain` (only noise is left), or `no_law` (no law of one
            variable earns its place).
        model: the effects that stand beside the curves, with the values that fit with them.
        learned: curves in the order in which they were taken.
        choice_baseline_rad, choice_rmse_rad: RMS errors on what was left out in turn.
        report_baseline_rad, report_rmse_rad: on recordings that neither fitted nor chose; None
            without. The baselines are those of the model that is compared with.
        ceilings: what each law alone could explain, on what is left out.
        fitted, reported: names of recordings.
    """

    verdict: str
    model: Model
    joints: tuple[str, ...]
    learned: tuple[Learned, ...]
    noise_floor_rad: float
    choice_baseline_rad: float
    choice_rmse_rad: float
    report_baseline_rad: float | None
    report_rmse_rad: float | None
    ceilings: tuple[Ceiling, ...]
    fitted: tuple[str, ...]
    reported: tuple[str, ...]

    @property
    def with_curves(self) -> Model:
        """The model with all curves."""
        return self.with_some([one.curve.law for one in self.learned])

    def without(self, one: Learned) -> Model:
        """The model with all curves but one."""
        return self.with_some([other.curve.law for other in self.learned if other is not one])

    def with_some(self, laws: Sequence[Law]) -> Model:
        """The model with the curves of some laws."""
        curves = (one.curve for one in self.learned if one.curve.law in laws)
        return replace(self.model, learned=(*self.model.learned, *curves))


def error_of(model: Model, predictor: Predictor, mask: np.ndarray | None = None) -> float:
    """RMS error in rad of a model on recordings."""
    layout, u = model.vector(predictor.joints)
    q = predictor.predict([Request(layout, u[None])])[0][0]
    left = (q - predictor.samples.q)[slice(None) if mask is None else mask]
    return float(np.sqrt(np.mean(left**2)))


def pooled_error(model: Model, sets: Sequence[tuple[Predictor, np.ndarray]]) -> float:
    """RMS error in rad of a model on samples of several predictors, given by their masks."""
    errors = [error_of(model, *each) for each in sets]
    return float(np.sqrt(np.average(np.square(errors), weights=[mask.sum() for _, mask in sets])))
