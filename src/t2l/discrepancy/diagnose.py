"""Which physical effect a model lacks: every known one is fitted, and judged on held-out data."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from t2l.discrepancy import judge
from t2l.discrepancy.candidate import Candidate, Pair, mark_ties, promote, rank
from t2l.discrepancy.evidence import Evidence, pooled
from t2l.discrepancy.fit import Fit, drop_hopeless, least_loss, run
from t2l.discrepancy.model import Model, from_vector
from t2l.discrepancy.noise import noise_floor
from t2l.discrepancy.pairs import best_pair
from t2l.discrepancy.prediction import Predictor, Request, check_finite
from t2l.discrepancy.scan import first_guesses
from t2l.discrepancy.search import search
from t2l.discrepancy.uncertainty import uncertainty
from t2l.effects.effect import Effect
from t2l.effects.term import Layout, Term

MISSING, NOTHING_MISSING, UNEXPLAINED = "missing_effect", "no_missing_effect", "unexplained"

AT_THE_FLOOR = 1.10  # times the noise floor: what remains is measurement
SHOWN = 2.0  # likewise: training recordings that leave more show that something is missing
NEAR_THE_FLOOR = 1.25  # likewise, if no effect improves on it
DIAGONAL_FROM_JOINTS = 4  # joints from which the search moves them all at once
ITERATIONS = 8
REFINEMENTS = 3
LEADERS = 4
PARTIAL = 1.5  # times the noise floor: an effect that leaves more may have a companion
NEAR = 4.0  # times the least loss: what may still turn out to be best
INSIGNIFICANT = 2.0  # standard errors from neutral

Progress = Callable[[str, float], None]


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
    seed: int = 0,
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
        effects = list(model.known_effects().values())
    effects = [effect for effect in effects if effect.name not in everywhere]

    train_q, held_q = _predict(evidence, adopted, u)
    before = _residual(evidence.holdout, evidence.holdout_mask, held_q)
    floor, heldout = _floor(evidence, held_q), _rms(before)
    ranking = []
    if effects and not (quick and heldout <= AT_THE_FLOOR * floor):
        fits, leaders, pair = _fit_all(evidence, adopted, u, effects, floor, progress)
        progress("judging on held-out data", 0.9)
        candidates = _judge(evidence, fits, before, seed)
        for candidate in candidates:
            name = candidate.effect.name
            where = (evidence.train, evidence.train_mask)
            if name not in leaders:
                where = (evidence.screen, evidence.screen_mask)
            candidate.uncertainty = uncertainty(fits[name], *where)
        ranking = promote(rank(candidates), pair)
        mark_ties(ranking)
    train = _rms(_residual(evidence.train, evidence.train_mask, train_q))
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


def _fit_all(
    evidence: Evidence,
    adopted: Layout,
    u: np.ndarray,
    effects: Sequence[Effect],
    floor: float,
    progress: Progress,
) -> tuple[dict[str, Fit], list[str], Pair | None]:
    """Every effect fitted on what is screened, the leaders on everything; the best pair."""
    diagonal = len(evidence.train.joints) >= DIAGONAL_FROM_JOINTS
    progress("first guesses", 0.0)
    guesses = first_guesses(evidence.screen, evidence.screen_mask, adopted, u, effects)
    progress("fitting every effect", 0.2)
    fits = {
        name: Fit(layout, start, size, diagonal) for name, (layout, start, size) in guesses.items()
    }
    run(list(fits.values()), evidence.screen, evidence.screen_mask, ITERATIONS, drop_hopeless)
    _search_rough(fits, evidence)
    pair = None
    if least_loss(fits) > (PARTIAL * floor) ** 2:
        progress("trying pairs of effects", 0.5)
        pair = best_pair(fits, evidence, diagonal)
    progress("refining the best", 0.7)
    leaders = _leaders(fits, pair)
    fits |= _refine({name: fits[name] for name in leaders}, evidence, diagonal)
    return fits, leaders, pair


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
    return noise_floor(list(predictor.recordings), predictor.by_row(predictor.samples.q - q))


def _search_rough(fits: dict[str, Fit], evidence: Evidence) -> None:
    """Search on where derivatives got stuck, if the effect may still turn out to be best."""
    rough = [
        fit
        for fit in fits.values()
        if any(t.effect.rough_error for t in fit.layout.terms)
        and fit.loss <= NEAR * least_loss(fits)
    ]
    search(rough, evidence.screen, evidence.screen_mask)
    moved = [fit for fit in rough if fit.jacobian is None]
    run(moved, evidence.screen, evidence.screen_mask, REFINEMENTS)


def _leaders(fits: dict[str, Fit], pair: Pair | None) -> list[str]:
    """Names of the few effects worth fitting on everything, best first."""
    ranked = sorted(fits, key=lambda name: fits[name].loss)
    best = fits[ranked[0]].loss
    near = [name for name in ranked if fits[name].loss <= NEAR * best]
    leaders = near[:LEADERS] if len(near) > 1 else ranked[:2]
    members = [] if pair is None else [pair.first, pair.second]
    return leaders + [name for name in members if name not in leaders]


def _refine(fits: dict[str, Fit], evidence: Evidence, diagonal: bool) -> dict[str, Fit]:
    """Fit on all training samples, and without the joints that show no sign of the effect."""
    refined = fits
    if evidence.screen is not evidence.train:
        refined = {name: Fit(fit.layout, fit.u, fit.size, diagonal) for name, fit in fits.items()}
        run(list(refined.values()), evidence.train, evidence.train_mask, REFINEMENTS)
    pruned = {}
    for name, fit in refined.items():
        smaller = _without_insignificant(name, fit, evidence)
        if smaller is not None:
            pruned[name] = smaller
    run(list(pruned.values()), evidence.train, evidence.train_mask, REFINEMENTS)
    # what a joint contributes beyond 1 % of the error is kept
    return refined | {
        name: fit for name, fit in pruned.items() if fit.loss < 1.02 * refined[name].loss
    }


def _without_insignificant(name: str, fit: Fit, evidence: Evidence) -> Fit | None:
    term = next(t for t in fit.layout.terms if t.effect.name == name)
    if not any(p.per_joint for p in term.effect.parameters) or fit.jacobian is None:
        return None
    found = uncertainty(fit, evidence.train, evidence.train_mask)
    keep = []
    for joint in term.joints:
        slots = [
            i for i, s in enumerate(fit.layout.slots)
            if s.term.effect.name == name and s.joint == joint
        ]  # fmt: skip
        if any(found.distance(i) > INSIGNIFICANT for i in slots):
            keep.append(joint)
    if not keep or len(keep) == len(term.joints):
        return None
    layout = Layout([Term(t.effect, tuple(keep)) if t is term else t for t in fit.layout.terms])
    index = [
        i for i, s in enumerate(fit.layout.slots)
        if s.term is not term or s.joint is None or s.joint in keep
    ]  # fmt: skip
    return Fit(layout, fit.u[index], fit.size[index], fit.diagonal, damping=1e-3)


def _judge(
    evidence: Evidence, fits: dict[str, Fit], before: np.ndarray, seed: int
) -> list[Candidate]:
    usable = {name: fit for name, fit in fits.items() if np.isfinite(fit.loss)}
    requests = [Request(fit.layout, fit.u[None]) for fit in usable.values()]
    held = evidence.holdout.predict(requests)
    samples, mask = evidence.holdout.samples, evidence.holdout_mask
    block = judge.blocks(samples.recording[mask], samples.time[mask])
    candidates = []
    for (name, fit), q in zip(usable.items(), held, strict=True):
        after = _residual(evidence.holdout, mask, q[0])
        if not np.isfinite(after).all():
            continue
        effect = next(t.effect for t in fit.layout.terms if t.effect.name == name)
        candidates.append(
            Candidate(
                effect=effect,
                layout=fit.layout,
                u=fit.u,
                train_rmse_rad=float(np.sqrt(fit.loss)),
                heldout_rmse_rad=_rms(after),
                improvement=judge.improvement(before, after, block, np.random.default_rng(seed)),
                residual=after,
            )
        )
    return candidates
