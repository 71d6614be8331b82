"""One round of known effects, each alone: which of them explains most of what a model lacks."""

from collections.abc import Sequence

import numpy as np

from t2l.detective.certainty import chosen_shares
from t2l.detective.data_split import DataSplit
from t2l.detective.fitted_set import FittedSet
from t2l.detective.search import Singles, singles
from t2l.diagnose.candidate import Candidate, mark_ties, rank
from t2l.diagnose.confounded import Confounded
from t2l.diagnose.ranking import Diagnosis, verdict_of
from t2l.identify.levels import AT_THE_FLOOR
from t2l.identify.model import Model
from t2l.identify.prediction import Request
from t2l.identify.progress import Progress
from t2l.identify.scales import sized
from t2l.identify.uncertainty import uncertainty


def diagnose(
    model: Model,
    data: DataSplit,
    progress: Progress = lambda what, fraction: None,
    beforehand: Sequence[Confounded] = (),
) -> Diagnosis:
    """Each known effect fitted with those that the model has, judged on what is left out in turn.

    Args:
        beforehand: effects that the recordings do not tell apart, which are never certain.

    Raises:
        DivergenceError: the simulation of the model runs away.
    """
    model = sized(model, data.fitted)
    found = singles(model, data, progress)
    judge, came = found.judge, found.came
    quiet = AT_THE_FLOOR * judge.noise_rad
    simulated = {_new(came, fit): fit for fit in found.simulated}
    along = {_new(came, fit): fit for fit in found.along}
    sets = [came, *simulated.values()]
    candidates = [
        _candidate(name, fit, found, data, sets, name in simulated)
        for name, fit in (along | simulated).items()
    ]
    for candidate in candidates:
        candidate.confounded = next(
            (entry for entry in beforehand if entry.effect == candidate.effect.name), None
        )
    ranking = rank(candidates, quiet)
    mark_ties(ranking, quiet)
    error = came.left_out_rmse
    verdict = verdict_of(error, judge.noise_rad, bool(ranking) and ranking[0].justified)
    return Diagnosis(
        model, data.fitted.joints, verdict, judge.noise_rad, came.rmse, error,
        _tested(came, data), ranking,
    )  # fmt: skip


def _new(came: FittedSet, fit: FittedSet) -> str:
    """Name of the effect that a fit has more, or on more joints."""
    had = dict(came.names)
    return next(name for name, joints in sorted(fit.names) if had.get(name) != joints)


def _candidate(
    name: str,
    fit: FittedSet,
    found: Singles,
    data: DataSplit,
    sets: Sequence[FittedSet],
    simulated: bool,
) -> Candidate:
    effect = next(t.effect for t in fit.layout.terms if t.effect.name == name)
    gain = found.judge.improvement(found.came, fit)
    candidate = Candidate(
        effect, fit.layout, fit.u, fit.rmse, fit.left_out_rmse, gain, simulated=simulated
    )
    if simulated:
        joints = candidate.term.joints
        candidate.chosen_share = chosen_shares(sets, data.folds, {name: joints})[name]
        candidate.uncertainty = uncertainty(fit, data.fitted, data.fitted_mask)
        left = _tested(fit, data)
        candidate.test_rmse_rad = left if np.isfinite(left) else None
    return candidate


def _tested(fit: FittedSet, data: DataSplit) -> float:
    test = data.test
    q = test.predict([Request(fit.layout, fit.u[None])])[0][0]
    return float(np.sqrt(np.mean((q - test.samples.q)[data.test_mask] ** 2)))
