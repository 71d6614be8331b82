"""A model's own effects fitted anew to recordings, with intervals."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from t2l.effects.term import Layout
from t2l.identify.fitting import ITERATIONS, run
from t2l.identify.least_squares import LeastSquares
from t2l.identify.model import Model, from_vector
from t2l.identify.prediction import Predictor, Request, check_finite
from t2l.identify.scales import sized
from t2l.identify.uncertainty import Uncertainty, uncertainty
from t2l.recordings.recording import Recording

# numerics: of a parameter's range: what makes a difference where its value is zero
LEAST_SIZE = 0.01


@dataclass(frozen=True)
class Refit:
    """A fit that began at the model's own values.

    Attributes:
        before, after: RMS error in rad of the model as it is, and refitted.
        held: the same with one effect left as it is and the others refitted, by its name.
    """

    layout: Layout
    adopted: np.ndarray
    found: Uncertainty
    before: float
    after: float
    held: dict[str, float]


def refit(
    model: Model, recordings: Sequence[Recording], substeps: int = 1, hold_each: bool = False
) -> Refit:
    """Fit all effects of `model` to `recordings`.

    Args:
        hold_each: also fit with each effect held, one after the other.

    Raises:
        DivergenceError: the simulation of the model runs away.
    """
    predictor = Predictor(model.robot, recordings, substeps)
    layout, u = sized(model, predictor).vector(predictor.joints)
    request = Request(layout, u[None])
    q = predictor.predict([request])[0][0]
    check_finite(q, predictor, request)
    mask = np.ones(len(predictor.samples), bool)
    names = [slot.term.effect.name for slot in layout.slots]
    fits = {"": _fit(layout, u, np.ones(len(u), bool))}
    if hold_each and len(set(names)) > 1:
        fits |= {held: _fit(layout, u, np.array(names) != held) for held in dict.fromkeys(names)}
    run(list(fits.values()), predictor, mask, 2 * ITERATIONS)
    before = float(np.sqrt(np.mean((q - predictor.samples.q) ** 2)))
    held = {name: float(np.sqrt(fit.loss)) for name, fit in fits.items() if name}
    if hold_each and not held:
        held = dict.fromkeys(names, before)
    after = fits[""]
    return Refit(
        layout, u, uncertainty(after, predictor, mask), before, float(np.sqrt(after.loss)), held
    )


def refitted(model: Model, predictor: Predictor, mask: np.ndarray) -> Model:
    """The model with the parameters of its effects fitted anew to the samples of `mask`."""
    layout, u = sized(model, predictor).vector(predictor.joints)
    fit = _fit(layout, u, np.ones(len(u), bool))
    run([fit], predictor, mask, 2 * ITERATIONS)
    return from_vector(model, fit.layout, fit.u, predictor.joints)


def at_its_values(model: Model, predictor: Predictor, mask: np.ndarray) -> Uncertainty:
    """How well the samples of `mask`, which the model was fitted to, determine its own values.

    Raises:
        DivergenceError: the simulation of the model runs away.
    """
    layout, u = sized(model, predictor).vector(predictor.joints)
    fit = _fit(layout, u, np.ones(len(u), bool))
    # the round that looks at the start, and no step away from it
    run([fit], predictor, mask, 0)
    if not np.isfinite(fit.loss):
        request = Request(layout, u[None])
        check_finite(predictor.predict([request])[0][0], predictor, request)
    return uncertainty(fit, predictor, mask)


def _fit(layout: Layout, u: np.ndarray, free: np.ndarray) -> LeastSquares:
    stated = np.array([slot.size for slot in layout.slots], float)
    scale = np.array([slot.scale for slot in layout.slots])
    size = np.maximum(stated, LEAST_SIZE * np.abs(u) + 1e-9 * scale)
    span = LEAST_SIZE * np.where(layout.log, 1.0, layout.upper - layout.lower)
    size = np.where((u == 0) & (stated == 0), span, np.maximum(size, np.abs(u)))
    return LeastSquares(layout, u.copy(), size, free=free)
