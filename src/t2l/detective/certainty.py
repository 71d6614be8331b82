"""How sure the choice of effects is: how often resamples of what was left out choose them too.

The products that a screen keeps of each fold are weighted, which is the screen of a resample. It
chooses among the best sets that the search has looked at, and the best that lack an effect. The
weights are those of the Bayesian bootstrap, as few folds would often leave but one of their number.

Source: Rubin, The Bayesian bootstrap, 1981; Meinshausen and Bühlmann, Stability selection, 2010.
"""

from collections import Counter
from collections.abc import Mapping
from copy import copy

import numpy as np

from t2l.detective.screen import Screen

RESAMPLES = 30  # statistics: the standard error of a share of one half is 9 %
SEED = 0  # statistics: of the weights
BEST = 200  # numerics: sets to choose from
LACKING = 20  # numerics: sets that lack an effect


def chosen_shares(
    screen: Screen, added: Mapping[str, tuple[int, ...]], resamples: int = RESAMPLES
) -> dict[str, float]:
    """Of effects on joints, in which share of resamples the best set has them.

    Args:
        screen: after its search.
        added: names with the joints that they were added on; of several joints the least sure
            counts.
    """
    pairs = [(name, joint) for name, joints in added.items() for joint in joints]
    sets = _to_choose_from(screen, pairs)
    has = [_pairs(screen, members) for members in sets]
    rng = np.random.default_rng(SEED)
    counts: Counter[tuple[str, int]] = Counter()
    for _ in range(resamples):
        resampled = reweighted(screen, rng.exponential(size=len(screen.products)))
        errors = [one.error for one in resampled.scores(sets)]
        counts.update(has[int(np.argmin(errors))])
    return {
        name: min(counts[name, joint] for joint in joints) / resamples
        for name, joints in added.items()
    }


def reweighted(screen: Screen, weights: np.ndarray) -> Screen:
    """The same screen where each fold counts as often as its weight (nfold,) says."""
    same = copy(screen)
    same.products = weights[:, None, None] * screen.products
    same.total = same.products.sum(axis=0)
    same.known = {}
    return same


def _to_choose_from(screen: Screen, pairs: list[tuple[str, int]]) -> list[tuple[int, ...]]:
    ranked = [one.members for one in sorted(screen.known.values(), key=lambda one: one.error)]
    sets = dict.fromkeys(ranked[:BEST])
    for pair in pairs:
        lacking = [members for members in ranked if pair not in _pairs(screen, members)]
        sets |= dict.fromkeys(lacking[:LACKING])
    return list(sets)


def _pairs(screen: Screen, members: tuple[int, ...]) -> set[tuple[str, int]]:
    """Effects and single joints of a set."""
    chosen = screen.chosen(members)
    return {(one.effect.name, joint) for one in chosen for joint in one.joints}
