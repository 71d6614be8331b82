"""Take back effects that later ones made superfluous."""

from functools import partial

import numpy as np

from t2l.diagnose.evidence import Evidence
from t2l.diagnose.multi_fidelity import with_coarser_ticks
from t2l.diagnose.racing import LEAST_SIZE, fit_fully, moves_together
from t2l.diagnose.starting_points import starting_points_of
from t2l.effects.term import Layout, Term
from t2l.identify.fitting import ITERATIONS, drop_hopeless, run
from t2l.identify.least_squares import LeastSquares
from t2l.identify.levels import PROMISING, TIED
from t2l.identify.model import Model, from_vector
from t2l.identify.prediction import Predictor, Request
from t2l.identify.scales import sized

# derived: of the loss of the model on some recordings; more is not made good on others
NEARLY = PROMISING**2


def simplify(model: Model, evidence: Evidence) -> tuple[Model, list[str]]:
    """Drop each effect, or replace it by one it contains, where validation shows no cost.

    An early effect may have stood in for one that was found later.

    Returns:
        The model and the names of effects that were dropped or replaced.
    """
    joints, model = evidence.train.joints, sized(model, evidence.train)
    evidence = with_coarser_ticks(evidence, *model.vector(joints))
    gone: list[str] = []
    while True:
        layout, u = model.vector(joints)
        limit = (1 + TIED) ** 2 * _validation(evidence, layout, u)
        trials = _without_one(layout, u, joints) + _with_simpler(model, layout, u, evidence)
        part = evidence.shortlist is not evidence.train
        if part:
            best = _fit_all(trials, evidence.screen, evidence.screen_mask, layout, u)
            trials = [(name, fit.again()) for name, fit in trials if fit.loss < NEARLY * best]
        _fit_all(trials, evidence.shortlist, evidence.shortlist_mask, layout, u)
        if part:
            trials = [entry for entry in trials if _error(evidence, entry[1]) < NEARLY * limit]
            trials = [(n, fit_fully({n: fit}, [n], evidence)[n]) for n, fit in trials]
        kept = [(_error(evidence, fit), name, fit) for name, fit in trials]
        kept = [entry for entry in kept if entry[0] <= limit]
        if not kept:
            return model, gone
        _, name, fit = min(kept, key=lambda entry: (len(entry[2].layout), entry[0]))
        model = from_vector(model, fit.layout, fit.u, joints)
        gone.append(name)


def _error(evidence: Evidence, fit: LeastSquares) -> float:
    """Validation error of a fit; infinite where it runs away."""
    return _validation(evidence, fit.layout, fit.u) if np.isfinite(fit.loss) else np.inf


def _fit_all(
    trials: list[tuple[str, LeastSquares]],
    predictor: Predictor,
    mask: np.ndarray,
    layout: Layout,
    u: np.ndarray,
) -> float:
    """Fit the trials to the samples; the loss there of the model they are trials for."""
    best = _loss(predictor, mask, layout, u)
    run([fit for _, fit in trials], predictor, mask, ITERATIONS, partial(drop_hopeless, best=best))
    return best


def _without_one(
    layout: Layout, u: np.ndarray, joints: tuple[str, ...]
) -> list[tuple[str, LeastSquares]]:
    if len(layout.terms) < 2:
        return []
    values = _values(layout, u)
    return [
        (
            term.effect.name,
            _fit(Layout([t for t in layout.terms if t is not term]), values, joints),
        )
        for term in layout.terms
    ]


def _with_simpler(
    model: Model, layout: Layout, u: np.ndarray, evidence: Evidence
) -> list[tuple[str, LeastSquares]]:
    known, trials = model.known_effects(evidence.train.joints), []
    present = {term.effect.name for term in layout.terms}
    for term in layout.terms:
        simpler = [known[n] for n in term.effect.contains if n in known and n not in present]
        rest = Layout([t for t in layout.terms if t is not term])
        values = _values(layout, u)
        guesses = starting_points_of(
            [Term(effect, term.joints) for effect in simpler],
            evidence.screen, evidence.screen_mask, rest, rest.encode(values),
        )  # fmt: skip
        for (with_simpler, start, _), _ in guesses:
            fit = _fit(with_simpler, _values(with_simpler, start), evidence.train.joints)
            trials.append((term.effect.name, fit))
    return trials


def _values(layout: Layout, u: np.ndarray) -> dict[str, dict[str, np.ndarray]]:
    return {
        name: {parameter: value[0] for parameter, value in parameters.items()}
        for name, parameters in layout.decode(u[None]).items()
    }


def _fit(layout: Layout, values, joints: tuple[str, ...]) -> LeastSquares:
    u = layout.encode(values)
    least = LEAST_SIZE * np.array([slot.scale for slot in layout.slots])
    return LeastSquares(layout, u, np.maximum(np.abs(u), least), moves_together(joints))


def _validation(evidence: Evidence, layout: Layout, u: np.ndarray) -> float:
    return _loss(evidence.validation, evidence.validation_mask, layout, u)


def _loss(predictor: Predictor, mask: np.ndarray, layout: Layout, u: np.ndarray) -> float:
    """Mean squared error, rad²."""
    q = predictor.predict([Request(layout, u[None])])[0][0]
    return float(np.mean((q - predictor.samples.q)[mask] ** 2))
