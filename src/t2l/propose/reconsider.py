"""Where known effects end: what a law would explain, and which names stand beside it.

An effect of the library may be adopted because it does a part of what an unknown torque does. So
when known effects end above the noise, laws are learned beside them. If these leave clearly less
(the rule is in `t2l.propose.decision`), each name must show that it is still needed: it is dropped
if the others and the laws, fitted again without it, leave as little.

Several wrong names together may even reach the noise. So two names or more stand against one law
alone: they are dropped if it leaves as little with fewer effective parameters than they have.

Laws are learned from training samples alone. All validation samples decide between the model that
has them and the one with the names, by the paired block bootstrap that decides everything else
(`t2l.propose.confirmation`). What is refused there gives way to the same laws beside all names, and
these to the names alone.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from t2l.diagnose.evidence import Evidence
from t2l.identify.fitting import REFINEMENTS
from t2l.identify.levels import SHORTLISTED
from t2l.identify.model import Model
from t2l.identify.prediction import Predictor, Request
from t2l.propose.confirmation import confirmed
from t2l.propose.decision import NEAR, Decision, decide
from t2l.propose.freedom import freedom
from t2l.propose.proposal import Proposal, error_of, finished
from t2l.propose.refit import State, refit, without
from t2l.propose.search import MOST_LAWS, Progress, Search, search
from t2l.propose.split import few, split
from t2l.recordings.recording import Recording


@dataclass(frozen=True)
class Reconsidered:
    """The final model, and what is proposed.

    Attributes:
        model: the names, if all stand; otherwise those that stand, and the laws in place of others.
        proposal: its baseline is the model with all names.
        dropped: names of adopted effects that do not stand.
        came_rmse_rad: what the model as it came leaves on the recordings that report.
        decision: on all adopted effects together.
    """

    model: Model
    proposal: Proposal
    dropped: tuple[str, ...]
    came_rmse_rad: float
    decision: Decision | None


@dataclass(frozen=True)
class _Offer:
    """Laws, the names they would take the place of, and the decision on all names together."""

    found: Search
    dropped: tuple[str, ...] = ()
    decision: Decision | None = None


@dataclass(frozen=True)
class _Samples:
    """What laws are learned from.

    Attributes:
        fitted, chosen: (nsample,) bool of the samples to fit, and to choose by.
        others: recordings that the laws must also predict.
    """

    predictor: Predictor
    fitted: np.ndarray
    chosen: np.ndarray
    others: tuple[Recording, ...]

    def search(self, model: Model, progress: Progress, most: int = MOST_LAWS) -> Search:
        """Laws beside a model."""
        return search(model, self.predictor, self.fitted, self.chosen, progress, most, self.others)


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
    predictor, at = few(evidence.train, SHORTLISTED)
    sets = evidence.train, evidence.validation, evidence.test
    samples = _Samples(
        predictor,
        *(half & evidence.train_mask[at] for half in split(predictor)),
        tuple(recording for each in sets for recording in each.recordings),
    )
    last = None
    for last in _offers(original, final, evidence, samples, quiet, progress):
        proposal = finished(
            *(final, last.found, predictor, evidence.test),
            *(evidence.train_mask[at], evidence.test_mask),
        )
        if not last.found.laws or confirmed(proposal, final, bool(last.dropped), evidence):
            return Reconsidered(
                proposal.with_curves if last.dropped else final, proposal, last.dropped,
                error_of(original, evidence.test, evidence.test_mask), last.decision,
            )  # fmt: skip
    return None


def _offers(
    original: Model,
    final: Model,
    evidence: Evidence,
    samples: _Samples,
    quiet: float,
    progress: Progress,
) -> Iterator[_Offer]:
    """What may take the place of the names, or stand beside them; last the names alone.

    Nothing more is offered where the names leave only noise.
    """
    adopted = tuple(name for name in final.effects if name not in original.effects)
    names_left = error_of(final, samples.predictor, samples.chosen)
    if len(adopted) > 1:
        one = _one_law(original, final, adopted, names_left, samples, progress)
        if one is not None:
            yield _Offer(replace(one, baseline_rad=names_left), adopted)
    # a wrong name may do where little happens, so the samples that it was fitted to count too
    sets = (evidence.validation, evidence.validation_mask), (evidence.train, evidence.train_mask)
    if all(error_of(final, *each) <= quiet for each in sets):
        return
    beside = samples.search(final, progress)
    decision = None
    if adopted:
        came = error_of(original, samples.predictor, samples.chosen)
        decision = decide(beside.baseline_rad, beside.rmse_rad, came, beside.noise_floor_rad)
        yield from _in_place(original, adopted, beside, decision, samples, progress)
    if beside.laws:
        yield _Offer(beside, decision=decision)
    state = State(*final.vector(samples.predictor.joints))
    yield _Offer(replace(beside, state=state, rmse_rad=beside.baseline_rad))


def _in_place(
    original: Model,
    adopted: Sequence[str],
    beside: Search,
    decision: Decision,
    samples: _Samples,
    progress: Progress,
) -> Iterator[_Offer]:
    """Laws in place of some names: those found beside them, or without them."""
    if not beside.laws:
        # what known effects leave may hide what a law would show
        alone = samples.search(original, progress)
        if alone.laws and beside.rmse_rad > NEAR * max(alone.rmse_rad, alone.noise_floor_rad):
            decision = decide(
                beside.rmse_rad, alone.rmse_rad, alone.baseline_rad, alone.noise_floor_rad
            )
            yield _Offer(replace(alone, baseline_rad=beside.baseline_rad), tuple(adopted), decision)
        return
    if not decision.named:
        progress("testing the names beside the curves", 0.8)
        found, dropped = _eliminate(beside, adopted, samples)
        if dropped:
            yield _Offer(found, tuple(dropped), decision)


def _one_law(
    original: Model,
    final: Model,
    adopted: Sequence[str],
    names_left: float,
    samples: _Samples,
    progress: Progress,
) -> Search | None:
    """One law beside the model as it came, if it does what several names do with less.

    Args:
        names_left: rad, on the choosing samples.
    """
    predictor, fitted, chosen = samples.predictor, samples.fitted, samples.chosen
    layout, _ = final.vector(predictor.joints)
    numbers = sum(slot.term.effect.name in adopted for slot in layout.slots)
    found = samples.search(original, progress, most=1)
    if not found.laws or found.rmse_rad > NEAR * max(names_left, found.noise_floor_rad):
        return None
    return found if freedom(found, predictor, fitted, chosen) < numbers else None


def _eliminate(
    found: Search, adopted: Sequence[str], samples: _Samples
) -> tuple[Search, list[str]]:
    """`found` without the names whose loss costs nothing, and their list."""
    limit = NEAR * max(found.rmse_rad, found.noise_floor_rad)
    dropped: list[str] = []
    while left := [name for name in adopted if name not in dropped]:
        trials = [without(found.state, [name]) for name in left]
        refit(trials, samples.predictor, samples.fitted, REFINEMENTS)
        errors = [_error(state, samples) for state in trials]
        best = int(np.argmin(errors))
        if not errors[best] <= limit:
            break
        found = replace(found, state=trials[best], rmse_rad=errors[best])
        dropped.append(left[best])
    return found, dropped


def _error(state: State, samples: _Samples) -> float:
    """RMS error in rad on the choosing samples; infinite where the simulation runs away."""
    predictor = samples.predictor
    q = predictor.predict([Request(state.layout, state.u[None])])[0][0]
    error = float(np.sqrt(np.mean((q - predictor.samples.q)[samples.chosen] ** 2)))
    return error if np.isfinite(error) else np.inf
