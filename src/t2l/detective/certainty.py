"""How sure the choice of effects is: how often resamples of what was left out choose them too.

A resample weighs each part that was left out in turn, and takes the best of the sets that were
fitted by simulation and of the model without any. The weights are those of the Bayesian bootstrap,
as few parts would often leave but one of their number.

Source: Rubin, The Bayesian bootstrap, 1981; Meinshausen and Bühlmann, Stability selection, 2010.
"""

from collections import Counter
from collections.abc import Mapping, Sequence

import numpy as np

from t2l.detective.fitted_set import FittedSet
from t2l.detective.screen import PARSIMONY

RESAMPLES = 200  # statistics: the standard error of a share of one half is 4 %
SEED = 0  # statistics: of the weights


def chosen_shares(
    sets: Sequence[FittedSet],
    folds: np.ndarray,
    added: Mapping[str, tuple[int, ...]],
    resamples: int = RESAMPLES,
) -> dict[str, float]:
    """Of effects on joints, in which share of resamples the best set has them.

    Args:
        sets: that were to choose from.
        folds: (nsample, k) numbers of the parts that each sample is left out with, in k ways.
        added: names with the joints that they were added on; of several joints the least sure
            counts.
    """
    # what is left out with the same others in all ways is one part
    _, fold = np.unique(folds, axis=0, return_inverse=True)
    errors = np.array(
        [np.bincount(fold, one.left_out**2) * (1 + PARSIMONY * one.complexity) for one in sets]
    )
    weights = np.random.default_rng(SEED).exponential(size=(resamples, errors.shape[1]))
    counts: Counter[tuple[str, int]] = Counter()
    for best in np.argmin(weights @ errors.T, axis=1):
        counts.update((name, joint) for name, joints in sets[best].names for joint in joints)
    return {
        name: min(counts[name, joint] for joint in joints) / resamples
        for name, joints in added.items()
    }
