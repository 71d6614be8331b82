"""Which physical effect a model lacks: every known one is fitted, and judged on validation data."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from t2l.diagnose.candidate import Candidate, alike, mark_ties, promote, rank
from t2l.diagnose.confounded import Confounded
from t2l.diagnose.evidence import Evidence, pooled
from t2l.diagnose.judging import judge, judge_in_turn, residual, rms
from t2l.diagnose.multi_fidelity import with_beginnings, with_coarser_ticks
from t2l.diagnose.racing import fit_all, fit_fully
from t2l.effects.effect import Effect
from t2l.effects.term import Layout
from t2l.identify.levels import AT_THE_FLOOR, MATERIAL
from t2l.identify.model import Model, from_vector
from t2l.identify.noise_floor import noise_floor
from t2l.identify.prediction import Predictor, Request, check_finite
from t2l.identify.progress import Progress
from t2l.identify.scales import sized
from t2l.identify.uncertainty import uncertainty

MISSING, NOTHING_MISSING, UNEXPLAINED = "missing_effect", "no_missing_effect", "unexplained"

# derived: times the noise floor: likewise, if no effect improves on it
NEAR_THE_FLOOR = AT_THE_FLOOR**2
# derived: times the training error before: a fit that ran away, whatever validation says
HARMFUL = 1 + MATERIAL


@dataclass
class Diagnosis:
    """What was found.

    Attributes:
        verdict: one of `missing_effect`, `no_missing_effect`, `unexplained`.
        noise_floor_rad: RMS error of a perfect model.
        train_rmse_rad, validation_rmse_rad, test_rmse_rad: of the model so far. The test
            samples chose nothing.
        ranking: candidates, in the order of `t2l.diagnose.candidate.rank`.
    """

    model: Model
    joints: tuple[str, ...]
    verdict: str
    noise_floor_rad: float
    train_rmse_rad: float
    validation_rmse_rad: float
    test_rmse_rad: float
    ranking: list[Candidate]


def diagnose(
    model: Model,
    evidence: Evidence,
    effects: Sequence[Effect] | None = None,
    progress: Progress = lambda what, fraction: None,
    quick: bool = False,
    beforehand: Sequence[Confounded] = (),
) -> Diagnosis:
    """Fit the model so far plus each effect on the training samples; judge on validation.

    The verdict and the ranking come from training and validation samples alone.

    Args:
        effects: candidates; by default every known one that some joint does not have yet.
        progress: called with a sentence and the fraction done.
        quick: try no effect if the error is at the noise floor already.
        beforehand: effects that the recordings do not tell apart, which are never certain.

    Raises:
        DivergenceError: a simulation of the model so far runs away.
    """
    joints, model = evidence.train.joints, sized(model, evidence.train)
    adopted, u = model.vector(joints)
    sets = evidence.train, evidence.validation, evidence.test
    if effects is None:
        recordings = [recording for each in sets for recording in each.recordings]
        effects = model.missing_effects(joints, recordings)
    else:
        everywhere = model.everywhere(joints)
        known = model.known_effects(joints)
        effects = [known.get(e.name, e) for e in effects if e.name not in everywhere]

    train_q, held_q, test_q = _predict(sets, adopted, u)
    before = residual(evidence.validation, evidence.validation_mask, held_q)
    train = rms(residual(evidence.train, evidence.train_mask, train_q))
    floor, chosen_by = _floor(evidence, held_q), rms(before)
    ranking = []
    if effects and not (quick and chosen_by <= AT_THE_FLOOR * floor):
        known = train_q if evidence.screen is evidence.train else None
        shorter = with_beginnings(evidence, adopted, u, known)
        cheaper = with_coarser_ticks(shorter, adopted, u)
        ranking = _ranking(cheaper, adopted, u, effects, floor, train, before, progress)
    for candidate in ranking:
        candidate.confounded = next(
            (entry for entry in beforehand if entry.effect == candidate.effect.name), None
        )
    verdict = verdict_of(chosen_by, floor, bool(ranking) and ranking[0].justified)
    test = rms(residual(evidence.test, evidence.test_mask, test_q))
    return Diagnosis(model, joints, verdict, floor, train, chosen_by, test, ranking)


def telling(model: Model, evidence: Evidence) -> Evidence:
    """`evidence`, unless validation recordings do not show what the training recordings show.

    Then no effect could earn its place there, and blocks of time of all of them choose.
    """
    if evidence.validation is evidence.train:
        return evidence
    layout, u = model.vector(evidence.train.joints)
    train_q, chosen_q = _predict((evidence.train, evidence.validation), layout, u)
    floor = _floor(evidence, chosen_q)
    error = rms(residual(evidence.validation, evidence.validation_mask, chosen_q))
    train = rms(residual(evidence.train, evidence.train_mask, train_q))
    silent = error <= AT_THE_FLOOR * floor and train > NEAR_THE_FLOOR * floor
    return pooled(evidence) if silent else evidence


def verdict_of(error: float, floor: float, justified: bool) -> str:
    """Of a validation error and a noise floor, rad, and whether an effect earns its place."""
    if error <= AT_THE_FLOOR * floor:
        return NOTHING_MISSING
    if justified:
        return MISSING
    return NOTHING_MISSING if error <= NEAR_THE_FLOOR * floor else UNEXPLAINED


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
    progress("judging on validation data", 0.85)
    candidates = judge_in_turn(evidence, found.fits, found.leaders, before)
    for name, candidate in candidates.items():
        candidate.chosen_share = found.shares[name]
        where = (evidence.screen, evidence.screen_mask)
        if name in found.leaders:
            where = (evidence.shortlist, evidence.shortlist_mask)
        candidate.uncertainty = uncertainty(found.fits[name], *where)
    full: set[str] = set()
    quiet = AT_THE_FLOOR * floor
    together = None
    if found.pair:
        both = {found.pair.second: found.pair.fit}
        pair = judge(evidence, both, before)
        together = next((judged.improvement for judged in pair.values()), None)
    while True:
        ranking = promote(rank(candidates.values(), quiet), found.pair, together)
        first = [name for name in alike(ranking, quiet) if name not in full]
        if not first:
            mark_ties(ranking, quiet)
            return ranking
        progress(f"fitting {', '.join(first)} to all recordings", 0.9)
        origin = dict(zip((slot.key for slot in adopted.slots), u, strict=True))
        fits = fit_fully(found.fits, first, evidence, origin)
        judged = judge(evidence, fits, before)
        for name in first:
            del candidates[name]
            if name in judged and judged[name].train_rmse_rad < HARMFUL * train:
                candidates[name] = judged[name]
                candidates[name].chosen_share = found.shares[name]
                candidates[name].uncertainty = uncertainty(
                    fits[name], evidence.train, evidence.train_mask
                )
        full.update(first)


def adopt(diagnosis: Diagnosis, name: str) -> Model:
    """The model with effect `name` of the ranking and the parameters fitted with it."""
    candidate = next(c for c in diagnosis.ranking if c.effect.name == name)
    return from_vector(diagnosis.model, candidate.layout, candidate.u, diagnosis.joints)


def _predict(predictors: Sequence[Predictor], layout: Layout, u: np.ndarray) -> list[np.ndarray]:
    """Position at every sample of each; of those that are one and the same once."""
    found: dict[Predictor, np.ndarray] = {}
    for predictor in predictors:
        if predictor not in found:
            request = Request(layout, u[None])
            found[predictor] = predictor.predict([request])[0][0]
            check_finite(found[predictor], predictor, request)
    return [found[predictor] for predictor in predictors]


def _floor(evidence: Evidence, q: np.ndarray) -> float:
    """Noise floor of the validation recordings, with the model's prediction taken off."""
    predictor = evidence.validation
    residuals = predictor.samples.by_row(predictor.samples.q - q)
    return noise_floor(list(predictor.recordings), residuals)
