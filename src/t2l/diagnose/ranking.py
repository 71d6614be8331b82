"""Which physical effect a model lacks: every known one is fitted, and judged on held-out data."""

import logging
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from t2l.diagnose.candidate import Candidate, alike, mark_ties, promote, rank
from t2l.diagnose.evidence import Evidence, pooled
from t2l.diagnose.multi_fidelity import with_beginnings, with_coarser_ticks
from t2l.diagnose.racing import Progress, fit_all, fit_fully
from t2l.effects.effect import Effect
from t2l.effects.term import Layout
from t2l.identify import block_bootstrap as judge
from t2l.identify.least_squares import LeastSquares
from t2l.identify.model import Model, from_vector
from t2l.identify.noise_floor import noise_floor
from t2l.identify.prediction import Predictor, Request, check_finite
from t2l.identify.uncertainty import uncertainty

logger = logging.getLogger(__name__)

MISSING, NOTHING_MISSING, UNEXPLAINED = "missing_effect", "no_missing_effect", "unexplained"

AT_THE_FLOOR = 1.10  # times the noise floor: what remains is measurement
SHOWN = 2.0  # likewise: training recordings that leave more show that something is missing
NEAR_THE_FLOOR = 1.25  # likewise, if no effect improves on it
HARMFUL = 1.05  # times the training error before: a fit that ran away, whatever is held out
SEED = 0  # of the bootstrap


@dataclass
class Diagnosis:
    """What was found.

    Attributes:
        verdict: one of `missing_effect`, `no_missing_effect`, `unexplained`.
        noise_floor_rad: RMS error of a perfect model.
        train_rmse_rad, heldout_rmse_rad: of the model so far.
        ranking: candidates, best first.
    """

    model: Model
    joints: tuple[str, ...]
    verdict: str
    noise_floor_rad: float
    train_rmse_rad: float
    heldout_rmse_rad: float
    ranking: list[Candidate]


def diagnose(
    model: Model,
    evidence: Evidence,
    effects: Sequence[Effect] | None = None,
    progress: Progress = lambda what, fraction: None,
    quick: bool = False,
) -> Diagnosis:
    """Fit the model so far plus each effect on the training samples; judge on the held-out ones.

    Args:
        effects: candidates; by default every known one that some joint does not have yet.
        progress: called with a sentence and the fraction done.
        quick: try no effect if the error is at the noise floor already.

    Raises:
        DivergenceError: a simulation of the model so far runs away.
    """
    joints = evidence.train.joints
    adopted, u = model.vector(joints)
    everywhere = {t.effect.name for t in adopted.terms if len(t.joints) == len(joints)}
    if effects is None:
        recordings = (*evidence.train.recordings, *evidence.holdout.recordings)
        known = model.known_effects(joints).values()
        effects = [effect for effect in known if effect.may_act(recordings)]
    effects = [effect for effect in effects if effect.name not in everywhere]

    train_q, held_q = _predict(evidence, adopted, u)
    before = _residual(evidence.holdout, evidence.holdout_mask, held_q)
    train = _rms(_residual(evidence.train, evidence.train_mask, train_q))
    floor, heldout = _floor(evidence, held_q), _rms(before)
    ranking = []
    if effects and not (quick and heldout <= AT_THE_FLOOR * floor):
        cheaper = with_coarser_ticks(with_beginnings(evidence, adopted, u), adopted, u)
        ranking = _ranking(cheaper, adopted, u, effects, floor, train, before, progress)
    verdict = _verdict(heldout, floor, ranking)
    return Diagnosis(model, joints, verdict, floor, train, heldout, ranking)


def telling(model: Model, evidence: Evidence) -> Evidence:
    """`evidence`, unless what is held out does not show what the training recordings show.

    Then no effect could earn its place there, and all recordings are judged by blocks of time.
    """
    if evidence.holdout is evidence.train:
        return evidence
    layout, u = model.vector(evidence.train.joints)
    train_q, held_q = _predict(evidence, layout, u)
    floor = _floor(evidence, held_q)
    heldout = _rms(_residual(evidence.holdout, evidence.holdout_mask, held_q))
    train = _rms(_residual(evidence.train, evidence.train_mask, train_q))
    silent = heldout <= AT_THE_FLOOR * floor and train > SHOWN * floor
    return pooled(evidence) if silent else evidence


def _verdict(heldout: float, floor: float, ranking: Sequence[Candidate]) -> str:
    if heldout <= AT_THE_FLOOR * floor:
        return NOTHING_MISSING
    if ranking and ranking[0].justified:
        return MISSING
    return NOTHING_MISSING if heldout <= NEAR_THE_FLOOR * floor else UNEXPLAINED


def _ranking(
    evidence: Evidence,
    adopted: Layout,
    u: np.ndarray,
    effects: Sequence[Effect],
    floor: float,
    train: float,
    before: np.ndarray,
    progress: Progress,
) -> list[Candidate]:
    """The effects fitted and judged, best first; what is first is fitted on all samples."""
    found = fit_all(evidence, adopted, u, effects, floor, progress)
    progress("judging on held-out data", 0.85)
    held, draft, draft_before = evidence.holdout_mask, evidence.holdout_draft, before
    if draft is not evidence.holdout:
        so_far = draft.predict([Request(adopted, u[None])])[0][0]
        draft_before = _residual(draft, held, so_far)
    candidates = _judge(draft, held, found.fits, draft_before)
    for name, candidate in candidates.items():
        where = (evidence.screen, evidence.screen_mask)
        if name in found.leaders:
            where = (evidence.shortlist, evidence.shortlist_mask)
        candidate.uncertainty = uncertainty(found.fits[name], *where)
    full: set[str] = set()
    together = None
    if found.pair:
        pair = _judge(draft, held, {found.pair.second: found.pair.fit}, draft_before)
        together = next((both.improvement for both in pair.values()), None)
    while True:
        ranking = promote(rank(candidates.values()), found.pair, together)
        first = [name for name in alike(ranking) if name not in full]
        if not first:
            mark_ties(ranking)
            return ranking
        progress(f"fitting {', '.join(first)} to all recordings", 0.9)
        origin = dict(zip((slot.key for slot in adopted.slots), u, strict=True))
        fits = fit_fully(found.fits, first, evidence, origin)
        judged = _judge(evidence.holdout, held, fits, before)
        for name in first:
            del candidates[name]
            if name in judged and judged[name].train_rmse_rad < HARMFUL * train:
                candidates[name] = judged[name]
                candidates[name].uncertainty = uncertainty(
                    fits[name], evidence.train, evidence.train_mask
                )
        full.update(first)


def adopt(diagnosis: Diagnosis, name: str) -> Model:
    """The model with effect `name` of the ranking and the parameters fitted with it."""
    candidate = next(c for c in diagnosis.ranking if c.effect.name == name)
    return from_vector(diagnosis.model, candidate.layout, candidate.u, diagnosis.joints)


def _rms(residual: np.ndarray) -> float:
    return float(np.sqrt(np.mean(residual**2)))


def _residual(predictor: Predictor, mask: np.ndarray, q: np.ndarray) -> np.ndarray:
    return (q - predictor.samples.q)[mask]


def _predict(evidence: Evidence, layout: Layout, u: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    train = evidence.train.predict([Request(layout, u[None])])[0][0]
    check_finite(train, evidence.train)
    if evidence.holdout is evidence.train:
        return train, train
    held = evidence.holdout.predict([Request(layout, u[None])])[0][0]
    check_finite(held, evidence.holdout)
    return train, held


def _floor(evidence: Evidence, q: np.ndarray) -> float:
    """Noise floor of the held-out recordings, with the model's prediction taken off."""
    predictor = evidence.holdout
    residuals = predictor.samples.by_row(predictor.samples.q - q)
    return noise_floor(list(predictor.recordings), residuals)


def _judge(
    predictor: Predictor, mask: np.ndarray, fits: dict[str, LeastSquares], before: np.ndarray
) -> dict[str, Candidate]:
    """By effect; those of which a simulation ran away are left out.

    Args:
        mask: samples of `predictor` that judge.
        before: their residual without the effects.
    """
    usable = {name: fit for name, fit in fits.items() if np.isfinite(fit.loss)}
    for name in fits.keys() - usable.keys():
        logger.warning("%s: left out, every simulation with it ran away", name)
    requests = [Request(fit.layout, fit.u[None]) for fit in usable.values()]
    held = predictor.predict(requests)
    samples = predictor.samples
    block = judge.blocks(samples.recording[mask], samples.time[mask])
    candidates = {}
    for (name, fit), q in zip(usable.items(), held, strict=True):
        after = _residual(predictor, mask, q[0])
        if not np.isfinite(after).all():
            logger.warning("%s: left out, a simulation of held-out recordings ran away", name)
            continue
        candidates[name] = Candidate(
            effect=next(t.effect for t in fit.layout.terms if t.effect.name == name),
            layout=fit.layout,
            u=fit.u,
            train_rmse_rad=float(np.sqrt(fit.loss)),
            heldout_rmse_rad=_rms(after),
            improvement=judge.improvement(before, after, block, np.random.default_rng(SEED)),
            residual=after,
        )
    return candidates
