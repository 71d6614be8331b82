"""Which effects the recordings cannot tell apart, said before any is named.

An effect is confounded with others if they do what it does (`t2l.design.collinearity`). That is
asked of each effect that alone explains at least half of what is missing, and as much as any,
linearised at the model as it came.
"""

import numpy as np

from t2l.design.collinearity import Responses
from t2l.design.identifiability import REFERENCE
from t2l.design.sensitivity import Sensitivity
from t2l.design.spans import spans
from t2l.diagnose.confounded import Confounded
from t2l.identify.fitting import run
from t2l.identify.least_squares import LeastSquares
from t2l.identify.levels import AT_THE_FLOOR, HALF, PROMISING, SHORTLISTED
from t2l.identify.model import Model
from t2l.identify.noise_floor import noise_floor
from t2l.identify.prediction import Predictor, Request
from t2l.identify.scales import sized

LEAST_SIZE = 1e-3  # numerics: of a parameter's scale, where it states no size


def confounded_beforehand(model: Model, predictor: Predictor, mask: np.ndarray) -> list[Confounded]:
    """Effects that alone explain most of what is missing, and that others may stand for.

    None where nothing is missing.

    Args:
        mask: (nsample,) bool, samples that fit and choose.
    """
    linear = _Linear(model, predictor, mask)
    missing = linear.responses.free(linear.residual)
    if _rms(missing) <= AT_THE_FLOOR:
        return []
    responses, half = linear.responses, HALF * np.mean(missing**2)
    parts = {name: responses.part(name, missing) for name in responses.index}
    parts = {name: part for name, part in parts.items() if np.mean(part**2) >= half}
    left = {name: max(_rms(missing - part), 1.0) for name, part in parts.items()}
    most = AT_THE_FLOOR * min(left.values(), default=0.0)
    found = [
        Confounded(
            name,
            tuple(responses.rivals(name, part, missing, PROMISING * left[name])),
            left[name] > AT_THE_FLOOR,
        )
        for name, part in parts.items()
        if left[name] <= most
    ]
    return [entry for entry in found if entry.rivals]


def spread(predictor: Predictor, mask: np.ndarray, count: int) -> tuple[Predictor, np.ndarray]:
    """A predictor of `count` recordings, spread over their gains, and its part of `mask`."""
    recordings = predictor.recordings
    order = sorted(range(len(recordings)), key=lambda i: (*recordings[i].kp, *recordings[i].kd))
    if count >= len(order):
        return predictor, mask
    chosen = np.sort(np.array(order)[np.round(np.linspace(0, len(order) - 1, count)).astype(int)])
    part = predictor.of([recordings[i] for i in chosen])
    return part, mask[np.isin(predictor.samples.recording, chosen)]


class _Linear:
    """The simulation around a model: what its own parameters do, and what each other effect does.

    All in units of the noise, at the samples that fit and choose.
    """

    def __init__(self, model: Model, predictor: Predictor, mask: np.ndarray):
        exact, mask = spread(predictor, mask, SHORTLISTED)
        joints, recordings = exact.joints, exact.recordings
        model = sized(model, exact)
        self.layout, self.u = model.vector(joints)
        ((q,),) = exact.predict([Request(self.layout, self.u[None])])
        signals = exact.samples.by_row(exact.samples.q - q)
        noise = max(noise_floor(list(recordings), signals), np.finfo(float).tiny)
        self.residual = (exact.samples.q - q)[mask] / noise
        effects = model.missing_effects(joints, recordings)
        few = spread(exact, mask, REFERENCE)[0].recordings
        sensitivity = Sensitivity(model, effects, few, noise, exact.substeps)
        self._predictor, self._mask, self._noise = sensitivity.predictor(recordings), mask, noise
        columns, self.names = spans(sensitivity, recordings)
        self.columns = columns[mask]
        known = model.known_effects(joints)
        self.excludes = {
            one: {other for other in known if other in e.contains or one in known[other].contains}
            for one, e in known.items()
        }
        self.base = self._base()
        self.responses = Responses(self.columns, self.names, self.base, self.excludes)

    def _base(self) -> np.ndarray:
        """(nsample, n) what the model's own parameters do."""
        least = [max(slot.size, LEAST_SIZE * slot.scale) for slot in self.layout.slots]
        fit = LeastSquares(self.layout, self.u, np.maximum(np.abs(self.u), least))
        run([fit], self._predictor, self._mask, 0)
        return np.nan_to_num(fit.jacobian) / self._noise


def _rms(values: np.ndarray) -> float:
    return float(np.sqrt(np.mean(values**2)))
