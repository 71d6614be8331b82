"""How sure the choice of effects is: how often resamples of what was left out choose them too.

The products that a screen keeps of each fold are weighted, which is the screen of a resample. The
weights are those of the Bayesian bootstrap, as few folds would often leave but one of their number.

Source: Rubin, The Bayesian bootstrap, 1981; Meinshausen and Bühlmann, Stability selection, 2010.
"""

from collections import Counter
from collections.abc import Mapping
from copy import copy

import numpy as np

from t2l.detective.screen import Screen

RESAMPLES = 20  # statistics: the standard error of a share of one half is 11 %
SEED = 0  # statistics: of the weights


def chosen_shares(
    screen: Screen, added: Mapping[str, tuple[int, ...]], resamples: int = RESAMPLES
) -> dict[str, float]:
    """Of effects on joints, in which share of resamples the best set has them.

    Args:
        added: names with the joints that they were added on; of several joints the least sure
            counts.
    """
    rng = np.random.default_rng(SEED)
    counts: Counter[tuple[str, int]] = Counter()
    for _ in range(resamples):
        resampled = reweighted(screen, rng.exponential(size=len(screen.products)))
        best = min(resampled.search(), key=lambda one: one.error)
        chosen = resampled.chosen(best.members)
        counts.update({(one.effect.name, joint) for one in chosen for joint in one.joints})
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
