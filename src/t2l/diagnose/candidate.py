"""Effects that were fitted, and which of them to believe first."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from t2l.diagnose.settings import CERTAIN, HARMLESS, MATERIAL
from t2l.effects.effect import Effect
from t2l.effects.term import Layout, Term
from t2l.identify.block_bootstrap import Improvement, improvement
from t2l.identify.uncertainty import Uncertainty


@dataclass
class Candidate:
    """The model so far with one more effect, fitted.

    Attributes:
        layout, u: the terms and their parameters, adopted ones included.
        train_rmse_rad, validation_rmse_rad: errors with it.
        test_rmse_rad: likewise, of samples that chose nothing; None until it is reported.
        improvement: over the model so far, by validation.
        residual: (nsample,) of the validation samples.
        uncertainty: intervals of u.
        tied_with: names of effects that explain as well.
        partner: the effects together with which it explains more than any alone.
        together: improvement of all of them over the model so far, by validation.
        chosen_share: how often it is selected, over resamples of what is screened.
        why: a sentence for people.
    """

    effect: Effect
    layout: Layout
    u: np.ndarray
    train_rmse_rad: float
    validation_rmse_rad: float
    improvement: Improvement
    residual: np.ndarray
    uncertainty: Uncertainty | None = None
    tied_with: list[str] = field(default_factory=list)
    partner: str | None = None
    together: Improvement | None = None
    why: str = ""
    test_rmse_rad: float | None = None
    chosen_share: float = 0.0

    @property
    def term(self) -> Term:
        """The effect on the joints that have it."""
        return next(t for t in self.layout.terms if t.effect.name == self.effect.name)

    @property
    def certain(self) -> bool:
        """Whether it is selected in at least half of the resamples."""
        return self.chosen_share >= CERTAIN

    @property
    def justified(self) -> bool:
        """Whether it, or it with its partner, earns its place on data it has not seen."""
        return is_better(self.improvement) or (
            self.together is not None and is_better(self.together)
        )


def is_better(found: Improvement) -> bool:
    """The one rule of adoption, removal, sets and ties: better by enough, and hardly by chance."""
    return found.fraction >= MATERIAL and found.lower > -HARMLESS


def beats(after: np.ndarray, before: np.ndarray, block: np.ndarray) -> bool:
    """Whether residuals `after` are better than `before`, (nsample,) in the same blocks."""
    if np.sum(after**2) > (1 - MATERIAL) ** 2 * np.sum(before**2):
        return False  # no resample is needed
    return is_better(improvement(before, after, block))


def rank(candidates: Sequence[Candidate], block: np.ndarray) -> list[Candidate]:
    """By validation error; first the one with fewest parameters that the least does not beat."""
    ranking = sorted(candidates, key=lambda c: c.validation_rmse_rad)
    if not ranking:
        return []
    alike = [c for c in ranking if not beats(ranking[0].residual, c.residual, block)]
    first = min(alike, key=lambda c: (len(c.layout), c.validation_rmse_rad))
    return [first, *(c for c in ranking if c is not first)]


def alike(ranking: Sequence[Candidate], block: np.ndarray) -> list[Candidate]:
    """Those that the first does not beat; none if it earns no place, or not by itself."""
    if not ranking or not ranking[0].justified or ranking[0].partner:
        return []
    first = ranking[0].residual
    return [c for c in ranking[1:] if c.justified and not beats(first, c.residual, block)]


def mark_ties(ranking: Sequence[Candidate], block: np.ndarray) -> None:
    """Note which effects explain as well as the first, unless one merely contains the other."""
    for other in alike(ranking, block):
        first = ranking[0]
        nested = (
            first.effect.name in other.effect.contains or other.effect.name in first.effect.contains
        )
        if not nested:
            first.tied_with.append(other.effect.name)
            other.tied_with.append(first.effect.name)


def promote(
    ranking: list[Candidate], sets: Mapping[tuple[str, ...], Candidate], block: np.ndarray
) -> list[Candidate]:
    """Put the members of a set first that is better than the first effect alone.

    Of several sets, one with as few effects as explain what the best does.

    Args:
        sets: fitted and judged, by the names of their effects.
    """
    if not ranking:
        return ranking
    good = {
        names: c for names, c in sets.items()
        if is_better(c.improvement) and beats(c.residual, ranking[0].residual, block)
    }  # fmt: skip
    if not good:
        return ranking
    least = min(good.values(), key=lambda c: c.validation_rmse_rad)
    names, found = min(
        ((n, c) for n, c in good.items() if not beats(least.residual, c.residual, block)),
        key=lambda entry: (len(entry[1].layout), entry[1].validation_rmse_rad),
    )
    members = [c for c in ranking if c.effect.name in names]
    for candidate in members:
        candidate.partner = " and ".join(n for n in names if n != candidate.effect.name)
        candidate.together = found.improvement
    return members + [c for c in ranking if c not in members]
