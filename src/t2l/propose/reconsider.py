"""Where known effects end: what a law would explain, and which names stand beside it.

An effect of the library may be adopted because it does a part of what an unknown torque does. So
when known effects end above the noise, laws are learned beside them. If these leave clearly less
(the rule is in `t2l.propose.decision`), each name must show that it is still needed: it is dropped
if the others and the laws, fitted again without it, leave as little.

Wrong names may even reach the noise, if they have numbers enough. So names stand against laws
alone: they are dropped if one law leaves clearly less, or laws leave as little with fewer effective
parameters than the names have for the same joints.

Laws are learned from training samples alone. All validation samples decide between the model that
has them and the one with the names, by the paired block bootstrap that decides everything else
(`t2l.propose.confirmation`). What is refused there gives way to the same laws beside all names, and
these to the names alone.

Names that stand are adopted if with each of them, and with laws beside them, the model goes half of
the way to the noise (`t2l.propose.decision.each_goes_half_way`). Otherwise they explain a part of
something that neither they nor the laws are. Then the model stays as it came, and laws are proposed
beside that.
"""

from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache

from t2l.diagnose.evidence import Evidence
from t2l.effects.law import Law
from t2l.effects.term import Slot
from t2l.identify.levels import SHORTLISTED
from t2l.identify.model import Model
from t2l.propose.confirmation import confirmed
from t2l.propose.decision import NEAR, Decision, decide, each_goes_half_way
from t2l.propose.elimination import eliminate
from t2l.propose.expression import Formula
from t2l.propose.formula_fit import formulas_of, in_words
from t2l.propose.found import Search, earns_its_place
from t2l.propose.freedom import freedom, independent
from t2l.propose.learning_samples import LearningSamples
from t2l.propose.proposal import Proposal, error_of, finished, pooled_error
from t2l.propose.refit import State
from t2l.propose.search import Progress, search
from t2l.propose.split import few, split


@dataclass(frozen=True)
class Reconsidered:
    """The final model, and what is proposed.

    Attributes:
        model: the names, if all stand; otherwise those that stand, and the laws in place of others.
            As it came, if they explain only a part.
        proposal: its baseline is the model with all names, or as it came if they explain a part.
        dropped: names of adopted effects that gave way to laws.
        came_rmse_rad, names_rmse_rad: what the model as it came, and with all names, leaves on the
            recordings that report.
        decision: on all adopted effects together.
        partial: names of adopted effects that explain only a part.
    """

    model: Model
    proposal: Proposal
    dropped: tuple[str, ...]
    came_rmse_rad: float
    names_rmse_rad: float
    decision: Decision | None
    partial: tuple[str, ...] = ()

    @property
    def explained(self) -> float:
        """The part of the squared error that all names explain, on the recordings that report."""
        return max(0.0, 1 - (self.names_rmse_rad / self.came_rmse_rad) ** 2)


@dataclass(frozen=True)
class _Offer:
    """Laws, the names they would take the place of, and the decision on all names together."""

    found: Search
    dropped: tuple[str, ...] = ()
    decision: Decision | None = None


@dataclass(frozen=True)
class _Learning:
    """How laws are learned and judged.

    Attributes:
        alone: learns laws without the names.
        formulas: of these.
        validated: rad, what laws leave of the validation samples, fitted to all training samples.
        alone_rad: what laws alone leave of them, as curves and in words.
        names_rad: what the names leave of them.
    """

    samples: LearningSamples
    alone: Callable[[], Search]
    formulas: Callable[[], Mapping[Law, Formula]]
    validated: Callable[[Search], float]
    alone_rad: tuple[Callable[[], float], ...]
    names_rad: float
    progress: Progress

    def alone_leave(self, enough: float) -> bool:
        """Whether laws alone leave as little, as curves or in words: these may reach further."""
        quiet = self.alone().noise_floor_rad <= enough
        return quiet and any(left() <= enough for left in self.alone_rad)


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
    samples = LearningSamples(
        predictor,
        *(half & evidence.train_mask[at] for half in split(predictor)),
        tuple(recording for each in sets for recording in each.recordings),
    )
    came, named = (
        error_of(model, evidence.test, evidence.test_mask) for model in (original, final)
    )

    @cache
    def at_first() -> float:
        return _fitted_and_chosen(original, evidence)

    @cache
    def alone() -> Search:
        return search(original, samples, progress)

    def told(model: Model, found: Search) -> Proposal:
        masks = evidence.train_mask[at], evidence.test_mask
        return finished(model, found, predictor, evidence.test, *masks)

    @cache
    def alone_told() -> Proposal:
        return told(original, alone())

    @cache
    def formulas() -> dict[Law, Formula]:
        return formulas_of(alone_told(), [(predictor, evidence.train_mask[at])])

    def left(model: Model) -> float:
        return error_of(model, evidence.validation, evidence.validation_mask)

    learning = _Learning(
        samples, alone, formulas,
        lambda found: left(told(final, found).with_curves),
        (
            cache(lambda: left(alone_told().with_curves)),
            cache(lambda: left(in_words(alone_told(), formulas()))),
        ),
        left(final), progress,
    )  # fmt: skip
    adopted, too_little = _adopted(original, final), False
    for offer in _offers(original, final, evidence, quiet, learning):
        proposal = told(final, offer.found)
        if offer.found.laws and not confirmed(proposal, final, bool(offer.dropped), evidence):
            continue
        stand = len(adopted) - len(offer.dropped)
        # with the laws beside them
        too_little = stand > 0 and not each_goes_half_way(
            stand, _fitted_and_chosen(proposal.with_curves, evidence), at_first(),
            proposal.noise_floor_rad,
        )  # fmt: skip
        if not too_little:
            model = proposal.with_curves if offer.dropped else final
            return Reconsidered(model, proposal, offer.dropped, came, named, offer.decision)
    if not too_little:
        return None
    proposal = alone_told()
    if alone().laws and not confirmed(proposal, original, False, evidence):
        proposal = told(original, _without_laws(original, alone(), predictor.joints))
    return Reconsidered(original, proposal, (), came, named, None, adopted)


def _adopted(original: Model, final: Model) -> tuple[str, ...]:
    return tuple(name for name in final.effects if name not in original.effects)


def _fitted_and_chosen(model: Model, evidence: Evidence) -> float:
    """RMS error in rad on training and validation samples: one recording alone tells little."""
    sets = (evidence.train, evidence.train_mask), (evidence.validation, evidence.validation_mask)
    return pooled_error(model, sets)


def _without_laws(model: Model, found: Search, joints: tuple[str, ...]) -> Search:
    return replace(found, state=State(*model.vector(joints)), rmse_rad=found.baseline_rad)


def _offers(
    original: Model,
    final: Model,
    evidence: Evidence,
    quiet: float,
    learning: _Learning,
) -> Iterator[_Offer]:
    """What may take the place of the names, or stand beside them; last the names alone.

    Nothing more is offered where the names leave only noise.
    """
    samples, alone = learning.samples, learning.alone
    adopted = _adopted(original, final)
    named = State(*final.vector(samples.predictor.joints))
    own = [slot for slot in named.layout.slots if slot.term.effect.name in adopted]
    # a law has one number at least
    most = max(Counter(slot.joint for slot in own).values(), default=0)
    if most > 1 and _say_more_simply(learning, named, own):
        names_left = error_of(final, samples.predictor, samples.chosen)
        yield _Offer(replace(alone(), baseline_rad=names_left), adopted)
    # a wrong name may do where little happens, so the samples that it was fitted to count too
    sets = (evidence.validation, evidence.validation_mask), (evidence.train, evidence.train_mask)
    if all(error_of(final, *each) <= quiet for each in sets):
        return
    beside = search(final, samples, learning.progress)
    decision = None
    if adopted:
        came = error_of(original, samples.predictor, samples.chosen)
        decision = decide(beside.baseline_rad, beside.rmse_rad, came, beside.noise_floor_rad)
        yield from _in_place(adopted, beside, decision, learning)
    if beside.laws:
        yield _Offer(beside, decision=decision)
    yield _Offer(_without_laws(final, beside, samples.predictor.joints))


def _in_place(
    adopted: Sequence[str],
    beside: Search,
    decision: Decision,
    learning: _Learning,
) -> Iterator[_Offer]:
    """Laws in place of some names: those found beside them, or without them."""
    found, dropped = beside, []
    if beside.laws:
        if decision.named:
            return
        learning.progress("testing the names beside the curves", 0.8)
        found, dropped = eliminate(beside, adopted, learning.samples)
    if len(dropped) < len(adopted):
        # names that need laws beside them stand for nothing that laws alone do as well; without
        # such laws they are simpler
        enough = learning.names_rad / NEAR
        if beside.laws:
            enough = NEAR * max(learning.validated(found), found.noise_floor_rad)
        # what known effects leave may hide what a law would show
        bare = learning.alone()
        if bare.laws and learning.alone_leave(enough):
            errors = bare.rmse_rad, bare.baseline_rad, bare.noise_floor_rad
            decision = decide(beside.baseline_rad, *errors)
            found, dropped = replace(bare, baseline_rad=beside.baseline_rad), [*adopted]
    if dropped:
        yield _Offer(found, tuple(dropped), decision)


def _say_more_simply(learning: _Learning, named: State, own: Sequence[Slot]) -> bool:
    """Whether one law leaves less than names, or laws leave as little with fewer numbers.

    Several names must need no more numbers than formulas do, too: a single name is one formula.

    Args:
        named: the model with the names.
        own: numbers of the names. Only those of the robot, and of the joints on which laws act,
            count: names have some for joints that need none.
    """
    found, samples = learning.alone(), learning.samples
    if not found.laws:
        return False
    # names were fitted to all training samples, so that those that chose laws favour them
    if not learning.alone_leave(NEAR * max(learning.names_rad, found.noise_floor_rad)):
        return False
    if len(found.laws) == 1:
        (residual,), _ = samples.left_by([named])
        if earns_its_place(residual, found.residual, samples):
            return True
    joints = {samples.predictor.joints.index(effect.law.joint) for effect in found.laws}
    counted = [slot for slot in own if slot.joint in (None, *joints)]
    numbers = independent(named, counted, samples)
    if freedom(found, samples) < numbers:
        return True
    several = len({slot.term.effect.name for slot in counted}) > 1
    return several and freedom(found, samples, learning.formulas()) < numbers
