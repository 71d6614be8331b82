"""Effects whose error has many small minima, searched without derivatives."""

from collections.abc import Sequence

import numpy as np

from t2l.identify.cma_es import CMAES, Part, default_population
from t2l.identify.fitting import run
from t2l.identify.least_squares import LeastSquares
from t2l.identify.prediction import Predictor

ROUNDS = 12  # tuned: populations of a search
SEED = 0  # statistics: of the search
# tuned: standard deviation of the first population in a logarithm, or of a parameter's own size
SPREAD = 0.4


def search(
    fits: Sequence[LeastSquares], predictor: Predictor, mask: np.ndarray, spread: float = 1.0
) -> list[np.ndarray]:
    """The best u (n,) that CMA-ES finds for the rough effects of each fit, all in one batch.

    Where a fit moves all joints at once, each joint is searched by itself in the same simulations.
    A fit's other parameters stay, and all do where nothing better is found.

    Args:
        mask: (nsample,) bool, the samples that judge.
        spread: of the first population, relative to what finds an effect from a first guess.
    """
    joints = predictor.samples.joint[mask]
    searches = [_search(fit, joints, spread) for fit in fits]
    run(searches, predictor, mask, ROUNDS)
    return [found.u for found in searches]


def _search(fit: LeastSquares, joints: np.ndarray, spread: float) -> CMAES:
    layout, parts = fit.layout, _parts(fit, joints)
    return CMAES(
        fit.u,
        np.stack([layout.lower, layout.upper], axis=1),
        sigma=1.0,
        population=max(default_population(len(part.index)) for part in parts),
        seed=SEED,
        origin=fit.u,
        scale=spread * SPREAD * np.where(layout.log, 1.0, fit.size),
        parts=parts,
        layout=layout,
    )


def _parts(fit: LeastSquares, joints: np.ndarray) -> list[Part]:
    rough = [
        i
        for i, slot in enumerate(fit.layout.slots)
        if slot.term.effect.rough_error and not slot.parameter.rough
    ]
    everywhere = np.ones(len(joints), bool)
    if not fit.diagonal:
        return [Part(np.array(rough), everywhere)]
    by_joint: dict[int | None, list[int]] = {}
    for i in rough:
        by_joint.setdefault(fit.layout.slots[i].joint, []).append(i)
    return [
        Part(np.array(index), everywhere if joint is None else joints == joint)
        for joint, index in by_joint.items()
    ]
