"""What the model with each fitted effect leaves on samples that chose none of its parameters.

Validation samples judge; what is left on test samples is noted with it, and judges nothing.
"""

import logging
from collections.abc import Collection, Mapping
from dataclasses import replace

import numpy as np

from t2l.diagnose.candidate import Candidate
from t2l.diagnose.evidence import Evidence
from t2l.identify import block_bootstrap
from t2l.identify.least_squares import LeastSquares
from t2l.identify.levels import PROMISING
from t2l.identify.prediction import Predictor, Request

logger = logging.getLogger(__name__)

SEED = 0  # statistics: of the bootstrap


def judge_in_turn(
    evidence: Evidence,
    fits: Mapping[str, LeastSquares],
    likely: Collection[str],
    before: np.ndarray,
) -> dict[str, Candidate]:
    """The likely effects on every tick, others so where they come near on ticks as screened.

    By effect, as `judge`.
    """
    coarse = _with_ticks(evidence, evidence.screen.coarseness)
    judged = judge(evidence, {name: fits[name] for name in likely}, before)
    others = {name: fit for name, fit in fits.items() if name not in likely}
    if coarse is evidence:
        return judged | judge(evidence, others, before)
    judged |= judge(coarse, others, before)
    least = min((c.validation_rmse_rad for c in judged.values()), default=np.inf)
    near = {
        name: fit
        for name, fit in others.items()
        if name in judged and judged[name].validation_rmse_rad <= PROMISING * least
    }
    judged = {name: found for name, found in judged.items() if name not in near}
    return judged | judge(evidence, near, before)


def judge(
    evidence: Evidence, fits: Mapping[str, LeastSquares], before: np.ndarray
) -> dict[str, Candidate]:
    """By effect; those of which a simulation ran away are left out.

    Args:
        before: (k,) residual of the validation samples without the effects, rad.
    """
    usable = {name: fit for name, fit in fits.items() if np.isfinite(fit.loss)}
    for name in fits.keys() - usable.keys():
        logger.warning("%s: left out, every simulation with it ran away", name)
    requests = [Request(fit.layout, fit.u[None]) for fit in usable.values()]
    predictor, mask = evidence.validation, evidence.validation_mask
    held = tested = predictor.predict(requests)
    if evidence.test is not predictor:
        tested = evidence.test.predict(requests)
    block = block_bootstrap.blocks(predictor.samples.recording[mask], predictor.samples.time[mask])
    candidates = {}
    for (name, fit), (q,), (test_q,) in zip(usable.items(), held, tested, strict=True):
        after = residual(predictor, mask, q)
        if not np.isfinite(after).all():
            logger.warning("%s: left out, a simulation of validation recordings ran away", name)
            continue
        reported = rms(residual(evidence.test, evidence.test_mask, test_q))
        candidates[name] = Candidate(
            effect=next(t.effect for t in fit.layout.terms if t.effect.name == name),
            layout=fit.layout,
            u=fit.u,
            train_rmse_rad=float(np.sqrt(fit.loss)),
            validation_rmse_rad=rms(after),
            improvement=block_bootstrap.improvement(
                before, after, block, np.random.default_rng(SEED)
            ),
            residual=after,
            # null where the model with it runs away there
            test_rmse_rad=reported if np.isfinite(reported) else None,
        )
    return candidates


def rms(values: np.ndarray) -> float:
    """Root of the mean square."""
    return float(np.sqrt(np.mean(values**2)))


def residual(predictor: Predictor, mask: np.ndarray, q: np.ndarray) -> np.ndarray:
    """(k,) rad, predicted minus measured position at the samples of `mask`."""
    return (q - predictor.samples.q)[mask]


def _with_ticks(evidence: Evidence, coarseness: int) -> Evidence:
    """`evidence` with what chooses and what reports simulated at ticks as coarse."""
    chooses, reports = evidence.validation, evidence.test
    if coarseness <= chooses.coarseness:
        return evidence
    coarse = chooses.of(chooses.recordings, coarseness)
    same = reports is chooses
    tested = coarse if same else reports.of(reports.recordings, coarseness)
    return replace(evidence, validation=coarse, test=tested)
