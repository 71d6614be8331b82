"""What may take the place of adopted names, or stand beside them: laws, learned both ways."""

from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

from t2l.diagnose.evidence import Evidence
from t2l.effects.law import Law
from t2l.effects.term import Slot
from t2l.identify.model import Model
from t2l.identify.progress import Progress
from t2l.propose.decision import NEAR, Decision, decide
from t2l.propose.elimination import eliminate
from t2l.propose.expression import Formula
from t2l.propose.found import Search, earns_its_place
from t2l.propose.freedom import freedom, independent
from t2l.propose.learning_samples import LearningSamples
from t2l.propose.proposal import error_of
from t2l.propose.refit import State
from t2l.propose.search import search


@dataclass(frozen=True)
class Offer:
    """Laws, the names they would take the place of, and the decision on all names together.

    Attributes:
        alone: whether the laws were learned without the names.
    """

    found: Search
    dropped: tuple[str, ...] = ()
    decision: Decision | None = None
    alone: bool = False


@dataclass(frozen=True)
class Learning:
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
    searches: Iterator[Progress]

    def alone_leave(self, enough: float) -> bool:
        """Whether laws alone leave as little, as curves or in words: these may reach further."""
        quiet = self.alone().noise_floor_rad <= enough
        return quiet and any(left() <= enough for left in self.alone_rad)


def adopted_in(original: Model, final: Model) -> tuple[str, ...]:
    """Names of the effects that `final` has and `original` has not."""
    return tuple(name for name in final.effects if name not in original.effects)


def without_laws(model: Model, found: Search, joints: tuple[str, ...]) -> Search:
    """A search that found nothing beside `model`."""
    return replace(found, state=State(*model.vector(joints)), rmse_rad=found.baseline_rad)


def offers(
    original: Model,
    final: Model,
    evidence: Evidence,
    quiet: float,
    learning: Learning,
) -> Iterator[Offer]:
    """What may take the place of the names, or stand beside them; last the names alone.

    Nothing more is offered where the names leave only noise.
    """
    samples, alone = learning.samples, learning.alone
    adopted = adopted_in(original, final)
    named = State(*final.vector(samples.predictor.joints))
    own = [slot for slot in named.layout.slots if slot.term.effect.name in adopted]
    # a law has one number at least
    most = max(Counter(slot.joint for slot in own).values(), default=0)
    if most > 1 and _say_more_simply(learning, named, own):
        names_left = error_of(final, samples.predictor, samples.chosen)
        yield Offer(replace(alone(), baseline_rad=names_left), adopted, alone=True)
    # a wrong name may do where little happens, so the samples that it was fitted to count too
    sets = (evidence.validation, evidence.validation_mask), (evidence.train, evidence.train_mask)
    if all(error_of(final, *each) <= quiet for each in sets):
        return
    beside = search(final, samples, next(learning.searches))
    decision = None
    if adopted:
        came = error_of(original, samples.predictor, samples.chosen)
        decision = decide(beside.baseline_rad, beside.rmse_rad, came, beside.noise_floor_rad)
        yield from _in_place(adopted, beside, decision, learning)
    if beside.laws:
        yield Offer(beside, decision=decision)
    yield Offer(without_laws(final, beside, samples.predictor.joints))


def _in_place(
    adopted: Sequence[str],
    beside: Search,
    decision: Decision,
    learning: Learning,
) -> Iterator[Offer]:
    """Laws in place of some names: those found beside them, or without them."""
    found, dropped, bare_laws = beside, [], False
    if beside.laws:
        if decision.named:
            return
        next(learning.searches)("testing the names beside the curves", 0.0)
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
            bare_laws = True
    if dropped:
        yield Offer(found, tuple(dropped), decision, bare_laws)


def _say_more_simply(learning: Learning, named: State, own: Sequence[Slot]) -> bool:
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
    acted_on = {name for effect in found.laws for name in (effect.law.joint, effect.law.of)}
    joints = {samples.predictor.joints.index(name) for name in acted_on}
    counted = [slot for slot in own if slot.joint in (None, *joints)]
    numbers = independent(named, counted, samples)
    if freedom(found, samples) < numbers:
        return True
    several = len({slot.term.effect.name for slot in counted}) > 1
    return several and freedom(found, samples, learning.formulas()) < numbers
