"""Effects that were fitted, and which of them to believe first."""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from t2l.diagnose.confounded import Confounded
from t2l.diagnose.settings import CERTAIN
from t2l.effects.effect import Effect
from t2l.effects.term import Layout, Term
from t2l.identify.block_bootstrap import Improvement
from t2l.identify.levels import MATERIAL, TIED
from t2l.identify.uncertainty import Uncertainty

LEAST_IMPROVEMENT = MATERIAL  # of the validation error; less is no finding


@dataclass
class Candidate:
    """The model so far with one more effect, fitted.

    Attributes:
        layout, u: the terms and their parameters, adopted ones included.
        train_rmse_rad, validation_rmse_rad: errors with it, on what is fitted and on what is left
            out in turn.
        test_rmse_rad: likewise, of samples that chose nothing; None until it is reported.
        improvement: over the model so far, by validation.
        uncertainty: intervals of u.
        tied_with: names of effects that explain as well.
        why: a sentence for people.
        chosen_share: in what share of the resamples of what is left out it explains most; None
            where it was not simulated.
        simulated: or fitted along the measured motion only, by the linear model of the loop.
        confounded: what the recordings do not tell it from, if there is anything.
    """

    effect: Effect
    layout: Layout
    u: np.ndarray
    train_rmse_rad: float
    validation_rmse_rad: float
    improvement: Improvement
    uncertainty: Uncertainty | None = None
    tied_with: list[str] = field(default_factory=list)
    why: str = ""
    test_rmse_rad: float | None = None
    chosen_share: float | None = None
    confounded: Confounded | None = None
    simulated: bool = True

    @property
    def term(self) -> Term:
        """The effect on the joints that have it."""
        return next(t for t in self.layout.terms if t.effect.name == self.effect.name)

    @property
    def certain(self) -> bool | None:
        """Whether it explains most in at least half of the resamples.

        Never where the recordings do not tell it from other effects.
        """
        if self.confounded is not None:
            return False
        return None if self.chosen_share is None else self.chosen_share >= CERTAIN

    @property
    def justified(self) -> bool:
        """Whether it earns its place on data it has not seen."""
        gain = self.improvement
        return self.simulated and gain.lower > 0 and gain.fraction >= LEAST_IMPROVEMENT


def _as_good_as(error: float, quiet: float) -> float:
    """The largest error in rad that explains as well as `error`."""
    return max((1 + TIED) * error, quiet)


def rank(candidates: Sequence[Candidate], quiet: float = 0.0) -> list[Candidate]:
    """Those that are justified before others, by validation error; of equals of few parameters.

    Args:
        quiet: RMSE in rad up to which all that is left is measurement.
    """
    left = sorted(candidates, key=lambda c: (not c.justified, c.validation_rmse_rad))
    ranking = []
    while left:
        best = left[0]
        limit = _as_good_as(best.validation_rmse_rad, quiet)
        alike = [c for c in left if c.validation_rmse_rad <= limit]
        alike = [c for c in alike if c.justified == best.justified]
        first = min(alike, key=lambda c: (len(c.layout), c.validation_rmse_rad))
        ranking.append(first)
        left.remove(first)
    return ranking


def mark_ties(ranking: Sequence[Candidate], quiet: float = 0.0) -> None:
    """Note which effects explain as well as the first, unless one merely contains the other."""
    if not ranking or not ranking[0].justified:
        return
    first = ranking[0]
    for other in (c for c in ranking[1:] if c.simulated):
        less, more = sorted((first.validation_rmse_rad, other.validation_rmse_rad))
        nested = (
            first.effect.name in other.effect.contains or other.effect.name in first.effect.contains
        )
        if more <= _as_good_as(less, quiet) and not nested:
            first.tied_with.append(other.effect.name)
            other.tied_with.append(first.effect.name)
