"""Where known effects end: what a law would explain, and which names stand beside it.

An effect of the library may be adopted because it does a part of what an unknown torque does. So
when known effects end above the noise, laws are learned beside them. If these leave clearly less
(the rule is in `t2l.propose.decision`), each name must show that it is still needed: it is dropped
if the others and the laws, fitted again without it, leave as little.

Several wrong names together may even reach the noise. So two names or more stand against one law
alone: they are dropped if it leaves as little with fewer effective parameters than they have.

Laws are learned from training samples alone. On validation samples they must show the same, or the
names stand as they are.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from t2l.diagnose.evidence import Evidence
from t2l.identify.model import Model
from t2l.identify.prediction import Predictor, Request
from t2l.propose.decision import NEAR, Decision, decide
from t2l.propose.freedom import freedom
from t2l.propose.laws import before_leaving
from t2l.propose.proposal import Proposal, error_of, finished
from t2l.propose.refit import State, refit
from t2l.propose.search import LEAST_IMPROVEMENT, Progress, Search, search, without
from t2l.propose.split import few, split

RECORDINGS = 12  # at most that curves are learned from: more cost time and add little
ITERATIONS = 3  # of a fit without one effect, which begins near its end


@dataclass(frozen=True)
class Reconsidered:
    """The model with the names that stand, and what is proposed.

    Attributes:
        model: without the laws; with the values that fit beside them where a name was dropped.
        dropped: names of adopted effects that do not stand.
        names_rmse_rad: what all adopted effects leave without a law, on the recordings that report.
        decision: on all adopted effects together.
    """

    model: Model
    proposal: Proposal
    dropped: tuple[str, ...]
    names_rmse_rad: float
    decision: Decision | None


def reconsider(
    original: Model,
    final: Model,
    evidence: Evidence,
    quiet: float,
    progress: Progress = lambda what, fraction: None,
) -> Reconsidered | None:
    """Learn laws beside `final`, which known effects made of `original`, and test the names.

    Args:
        quiet: rad, an error that counts as noise.

    Returns:
        None if the names stand and leave only noise.

    Raises:
        DivergenceError: a simulation of the model runs away.
    """
    predictor, at = few(evidence.train, RECORDINGS)
    fitted, chosen = (half & evidence.train_mask[at] for half in split(predictor))
    adopted = [name for name in final.effects if name not in original.effects]
    if len(adopted) > 1:
        one = _one_law(original, final, adopted, predictor, fitted, chosen, progress)
        if one is not None:
            return _reconsidered(original, final, one, adopted, evidence, None)
    # a wrong name may do where little happens, so the samples that it was fitted to count too
    sets = (evidence.validation, evidence.validation_mask), (evidence.train, evidence.train_mask)
    if all(error_of(final, *each) <= quiet for each in sets):
        return None
    found = search(final, predictor, fitted, chosen, progress)
    decision, dropped = None, []
    if adopted:
        before = error_of(original, predictor, chosen)
        if not found.laws:
            # what known effects leave may hide what a law would show
            alone = search(original, predictor, fitted, chosen, progress)
            if alone.laws and found.rmse_rad > NEAR * max(alone.rmse_rad, alone.noise_floor_rad):
                decision = decide(found.rmse_rad, alone.rmse_rad, before, alone.noise_floor_rad)
                found, dropped = alone, adopted
        if decision is None:
            decision = decide(found.baseline_rad, found.rmse_rad, before, found.noise_floor_rad)
            if not decision.named:
                progress("testing the names beside the curves", 0.8)
                dropped = _eliminate(found, adopted, predictor, fitted, chosen)
    return _reconsidered(original, final, found, dropped, evidence, decision)


def _reconsidered(
    original: Model,
    final: Model,
    found: Search,
    dropped: Sequence[str],
    evidence: Evidence,
    decision: Decision | None,
) -> Reconsidered:
    base = original if dropped or not set(final.effects) - set(original.effects) else final
    predictor, at = few(evidence.train, RECORDINGS)
    proposal = finished(
        base, found, predictor, evidence.test, evidence.train_mask[at], evidence.test_mask
    )
    if found.laws and not _confirmed(proposal, found, final, dropped, evidence):
        names_alone = _without_laws(found, final, predictor, split(predictor)[1])
        return _reconsidered(original, final, names_alone, [], evidence, None)
    model = proposal.model if dropped else final
    names = error_of(final, evidence.test, evidence.test_mask)
    return Reconsidered(model, proposal, tuple(dropped), names, decision)


def _confirmed(
    proposal: Proposal, found: Search, final: Model, dropped: Sequence[str], evidence: Evidence
) -> bool:
    """Whether laws do on validation samples what they did where they were chosen.

    If they do not, only samples count that a recording shows before it goes further than those that
    the laws were learned from. Where there was nothing to explain by then, nothing speaks against
    the laws.
    """
    predictor, measured = evidence.validation, evidence.validation.samples.q
    models = [model.vector(predictor.joints) for model in (proposal.with_curves, final)]
    requests = [Request(layout, u[None]) for layout, u in models]
    q, dq = predictor.predict(requests, velocity=True)
    inside = before_leaving(found.laws, predictor, q[0][0], dq[0][0])
    least, quiet = NEAR if dropped else 1 - LEAST_IMPROVEMENT, NEAR * found.noise_floor_rad
    for mask in (evidence.validation_mask, evidence.validation_mask & inside):
        with_laws, known = (_rms((one[0] - measured)[mask]) for one in q)
        if with_laws <= max(least * known, quiet):
            return True
    return known <= quiet


def _without_laws(found: Search, final: Model, predictor: Predictor, chosen: np.ndarray) -> Search:
    """`found`, had it taken no law beside `final`."""
    state, left = State(*final.vector(predictor.joints)), error_of(final, predictor, chosen)
    return replace(found, state=state, baseline_rad=left, rmse_rad=left)


def _one_law(
    original: Model,
    final: Model,
    adopted: Sequence[str],
    predictor: Predictor,
    fitted: np.ndarray,
    chosen: np.ndarray,
    progress: Progress,
) -> Search | None:
    """One law beside the model as it came, if it does what several names do with less."""
    layout, _ = final.vector(predictor.joints)
    numbers = sum(slot.term.effect.name in adopted for slot in layout.slots)
    found = search(original, predictor, fitted, chosen, progress, most=1)
    left = max(error_of(final, predictor, chosen), found.noise_floor_rad)
    if not found.laws or found.rmse_rad > NEAR * left:
        return None
    return found if freedom(found, predictor, fitted, chosen) < numbers else None


def _eliminate(
    found: Search,
    adopted: Sequence[str],
    predictor: Predictor,
    fitted: np.ndarray,
    chosen: np.ndarray,
) -> list[str]:
    """Drop names from `found` as long as that costs nothing; their list."""
    dropped: list[str] = []
    while left := [name for name in adopted if name not in dropped]:
        trials = [without(found.state, [name]) for name in left]
        refit(trials, predictor, fitted, ITERATIONS)
        errors = [_error(state, predictor, chosen) for state in trials]
        best = int(np.argmin(errors))
        limit = NEAR * max(found.rmse_rad, found.noise_floor_rad)
        if not errors[best] <= limit:
            break
        found.state = trials[best]
        dropped.append(left[best])
    return dropped


def _error(state: State, predictor: Predictor, mask: np.ndarray) -> float:
    q = predictor.predict([Request(state.layout, state.u[None])])[0][0]
    error = _rms((q - predictor.samples.q)[mask])
    return error if np.isfinite(error) else np.inf


def _rms(values: np.ndarray) -> float:
    return float(np.sqrt(np.mean(values**2))) if len(values) else 0.0
