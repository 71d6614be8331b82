"""Effects that were fitted, and which of them to believe first."""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from t2l.diagnose.confounded import Confounded
from t2l.diagnose.settings import CERTAIN, LEAST_SHARE
from t2l.effects.effect import Effect
from t2l.effects.term import Layout, Term
from t2l.identify.block_bootstrap import Improvement
from t2l.identify.least_squares import LeastSquares
from t2l.identify.levels import MATERIAL, NOTHING, TIED
from t2l.identify.uncertainty import Uncertainty

LEAST_IMPROVEMENT = MATERIAL  # of the validation error; less is no finding
# an effect that acts in few blocks leaves a resample without them as it was
HARMLESS = -NOTHING


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
        partner: the effect with which it explains far more than either alone.
        together: improvement of the two over the model so far, by validation.
        why: a sentence for people.
        chosen_share: in what share of the resamples of what is screened it explains as well as
            anything; None where these are too few to tell.
        confounded: what the recordings do not tell it from, if there is anything.
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
    chosen_share: float | None = None
    confounded: Confounded | None = None

    @property
    def term(self) -> Term:
        """The effect on the joints that have it."""
        return next(t for t in self.layout.terms if t.effect.name == self.effect.name)

    @property
    def certain(self) -> bool | None:
        """Whether it explains as well as anything in at least half of the resamples.

        Never where the recordings do not tell it from other effects.
        """
        if self.confounded is not None:
            return False
        return None if self.chosen_share is None else self.chosen_share >= CERTAIN

    @property
    def doubtful(self) -> bool:
        """Whether it does in hardly any: then one stretch of the log asks for it."""
        return self.chosen_share is not None and self.chosen_share < LEAST_SHARE

    @property
    def justified(self) -> bool:
        """Whether it, or it with its partner, earns its place on data it has not seen."""
        return (self.together is not None and _earns(self.together)) or self.stands_alone

    @property
    def stands_alone(self) -> bool:
        """Whether it earns its place without a partner, in more than hardly any resample."""
        return self.earns and not self.doubtful

    @property
    def earns(self) -> bool:
        """Whether it makes the validation error less."""
        return _earns(self.improvement)


@dataclass(frozen=True)
class Pair:
    """Two effects that explain together what neither does alone, and their fit."""

    first: str
    second: str
    fit: LeastSquares

    def partner(self, name: str) -> str:
        """The other one."""
        return self.second if name == self.first else self.first


def _as_good_as(error: float, quiet: float) -> float:
    """The largest error in rad that explains as well as `error`."""
    return max((1 + TIED) * error, quiet)


def rank(candidates: Sequence[Candidate], quiet: float = 0.0) -> list[Candidate]:
    """Those that stand alone before others, by validation error; of equals that of few parameters.

    So one that explains more and is not to be adopted hides none that is.

    Args:
        quiet: RMSE in rad up to which all that is left is measurement.
    """
    left = sorted(candidates, key=lambda c: (not c.stands_alone, c.validation_rmse_rad))
    ranking = []
    while left:
        best = left[0]
        limit = _as_good_as(best.validation_rmse_rad, quiet)
        alike = [c for c in left if c.validation_rmse_rad <= limit]
        alike = [c for c in alike if c.stands_alone == best.stands_alone]
        first = min(alike, key=lambda c: (c.doubtful, len(c.layout), c.validation_rmse_rad))
        ranking.append(first)
        left.remove(first)
    return ranking


def alike(ranking: Sequence[Candidate], quiet: float = 0.0) -> list[str]:
    """Names of the first and, if it earns its place, of those that explain as well as it.

    Less what merely contains it: parameters more that take nothing off.
    """
    if not ranking or not ranking[0].justified:
        return [c.effect.name for c in ranking[:1]]
    first = ranking[0]
    limit = _as_good_as(first.validation_rmse_rad, quiet)
    less = (1 - NOTHING) * first.validation_rmse_rad
    return [
        c.effect.name
        for c in ranking
        if c is first
        or (
            c.validation_rmse_rad <= limit
            and not c.doubtful
            and not (first.effect.name in c.effect.contains and c.validation_rmse_rad >= less)
        )
    ]


def mark_ties(ranking: Sequence[Candidate], quiet: float = 0.0) -> None:
    """Note which effects explain as well as the first, unless one merely contains the other."""
    if not ranking or not ranking[0].justified or ranking[0].partner:
        return
    first = ranking[0]
    for other in ranking[1:]:
        less, more = sorted((first.validation_rmse_rad, other.validation_rmse_rad))
        nested = (
            first.effect.name in other.effect.contains or other.effect.name in first.effect.contains
        )
        if more <= _as_good_as(less, quiet) and not nested and not other.doubtful:
            first.tied_with.append(other.effect.name)
            other.tied_with.append(first.effect.name)


def promote(
    ranking: list[Candidate], pair: Pair | None, together: Improvement | None
) -> list[Candidate]:
    """Put the members of a pair first if it earns its place; `together` is what it improves."""
    if pair is None or together is None or not _earns(together):
        return ranking
    members = [c for c in ranking if c.effect.name in (pair.first, pair.second)]
    for candidate in members:
        candidate.partner = pair.partner(candidate.effect.name)
        candidate.together = together
    return members + [c for c in ranking if c not in members]


def _earns(improvement: Improvement) -> bool:
    return improvement.lower > HARMLESS and improvement.fraction >= LEAST_IMPROVEMENT
