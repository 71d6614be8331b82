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

from dataclasses import dataclass
from functools import cache

from t2l.diagnose.evidence import Evidence
from t2l.effects.law import Law
from t2l.identify.levels import SHORTLISTED
from t2l.identify.model import Model
from t2l.identify.progress import Progress, pieces
from t2l.identify.scales import sized
from t2l.propose.confirmation import confirmed
from t2l.propose.decision import Decision, each_goes_half_way
from t2l.propose.expression import Formula
from t2l.propose.formula_fit import formulas_of, in_words
from t2l.propose.found import Search
from t2l.propose.learning_samples import LearningSamples
from t2l.propose.offers import Learning, adopted_in, offers, without_laws
from t2l.propose.proposal import Proposal, error_of, finished, pooled_error
from t2l.propose.search import search
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
    original, final = (sized(model, evidence.train) for model in (original, final))
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

    searches = pieces(progress)

    @cache
    def at_first() -> float:
        return _fitted_and_chosen(original, evidence)

    @cache
    def alone() -> Search:
        return search(original, samples, next(searches))

    def told(model: Model, found: Search) -> Proposal:
        masks = evidence.train_mask[at], evidence.test_mask
        others = evidence.train, evidence.validation
        return finished(model, found, predictor, evidence.test, *masks, others)

    @cache
    def alone_told() -> Proposal:
        return told(original, alone())

    @cache
    def formulas() -> dict[Law, Formula]:
        return formulas_of(alone_told(), [(predictor, evidence.train_mask[at])])

    def left(model: Model) -> float:
        return error_of(model, evidence.validation, evidence.validation_mask)

    ways = lambda: alone_told().with_curves, lambda: in_words(alone_told(), formulas())
    learning = Learning(
        samples, alone, formulas,
        lambda found: left(told(final, found).with_curves),
        tuple(cache(lambda way=way: left(way())) for way in ways),
        left(final), searches,
    )  # fmt: skip

    def confirms(proposal: Proposal, names: Model, replaced: bool, alone: bool) -> bool:
        models = ways if alone else (lambda: proposal.with_curves,)
        floor = proposal.noise_floor_rad
        return any(confirmed(model(), names, replaced, evidence, floor) for model in models)

    adopted, too_little = adopted_in(original, final), False
    for offer in offers(original, final, evidence, quiet, learning):
        proposal = told(final, offer.found)
        replaced = bool(offer.dropped)
        if offer.found.laws and not confirms(proposal, final, replaced, offer.alone):
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
    if alone().laws and not confirms(proposal, original, False, True):
        proposal = told(original, without_laws(original, alone(), predictor.joints))
    return Reconsidered(original, proposal, (), came, named, None, adopted)


def _fitted_and_chosen(model: Model, evidence: Evidence) -> float:
    """RMS error in rad on training and validation samples: one recording alone tells little."""
    sets = (evidence.train, evidence.train_mask), (evidence.validation, evidence.validation_mask)
    return pooled_error(model, sets)
