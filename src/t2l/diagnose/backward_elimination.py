"""Take back effects that later ones made superfluous."""

import numpy as np

from t2l.diagnose.candidate import beats
from t2l.diagnose.evidence import Evidence, validation_blocks
from t2l.diagnose.final_fit import adopted_sizes, fit_fully, moves_together
from t2l.diagnose.multi_fidelity import with_coarser_ticks
from t2l.diagnose.settings import HALVED_AFTER, ITERATIONS
from t2l.diagnose.starting_points import starting_points_of
from t2l.effects.term import Layout, Term
from t2l.identify.fitting import run
from t2l.identify.least_squares import LeastSquares
from t2l.identify.model import Model, from_vector
from t2l.identify.prediction import Predictor, Request


def simplify(model: Model, evidence: Evidence) -> tuple[Model, list[str]]:
    """Drop each effect, or replace it by one it contains, where validation shows no cost.

    An early effect may have stood in for one that was found later.

    Returns:
        The model and the names of effects that were dropped or replaced.
    """
    joints = evidence.train.joints
    evidence = with_coarser_ticks(evidence, *model.vector(joints))
    gone: list[str] = []
    while True:
        layout, u = model.vector(joints)
        whole = _validation(evidence, layout, u)
        trials = _without_one(layout, u, joints) + _with_simpler(model, layout, u, evidence)
        if evidence.draft is not evidence.train:
            run([f for _, f in trials], evidence.screen, evidence.screen_mask, HALVED_AFTER)
            trials.sort(key=lambda entry: entry[1].loss)
            trials = [(name, fit.again()) for name, fit in trials[: -(-len(trials) // 2)]]
        part = evidence.shortlist, evidence.shortlist_mask
        run([fit for _, fit in trials], *part, ITERATIONS)
        kept = [(name, fit) for name, fit in trials if np.isfinite(fit.loss)]
        left = [_validation(evidence, fit.layout, fit.u) for _, fit in kept]
        block = validation_blocks(evidence)
        kept = [e for e, r in zip(kept, left, strict=True) if not beats(whole, r, block)]
        if not kept:
            return model, gone
        name, fit = min(kept, key=lambda entry: (len(entry[1].layout), entry[1].loss))
        if evidence.shortlist is not evidence.train:
            fit = fit_fully({name: fit}, [name], evidence)[name]
        model = from_vector(model, fit.layout, fit.u, joints)
        gone.append(name)


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
    return LeastSquares(layout, u, adopted_sizes(layout, u), moves_together(joints))


def _validation(evidence: Evidence, layout: Layout, u: np.ndarray) -> np.ndarray:
    return _residual(evidence.validation, evidence.validation_mask, layout, u)


def _residual(predictor: Predictor, mask: np.ndarray, layout: Layout, u: np.ndarray) -> np.ndarray:
    q = predictor.predict([Request(layout, u[None])])[0][0]
    return (q - predictor.samples.q)[mask]
