"""The one rule: does what a model has more earn its place?

It must lower the error where it was not fitted, by enough to matter and by no chance. Both models'
errors are those on what was left out. Chance is judged by a paired bootstrap over blocks of time.

Source: Künsch, The jackknife and the bootstrap for general stationary observations, 1989.
"""

from dataclasses import dataclass

import numpy as np

from t2l.detective.fitted_set import FittedSet
from t2l.identify.block_bootstrap import Improvement, improvement
from t2l.identify.levels import AT_THE_FLOOR, MATERIAL, PROMISING, TIED

SEED = 0  # statistics: of the bootstrap


@dataclass(frozen=True)
class Judge:
    """Judges models by their errors on what was left out.

    Attributes:
        block: (nsample,) of each fitted sample.
        noise_rad: RMS error of a perfect model.
    """

    block: np.ndarray
    noise_rad: float

    def quiet(self, rmse_rad: float, as_it_came: bool = False) -> bool:
        """Whether an error is what measurement alone leaves: then nothing tells what is missing.

        Args:
            rmse_rad: of fitted samples. What is left out may have more, as numbers are unsure.
            as_it_came: of a model to which nothing was added. What is nearly as near is no reason
                to add something, as the noise too is an estimate.
        """
        return rmse_rad <= AT_THE_FLOOR ** (1 + as_it_came) * self.noise_rad

    def improvement(self, before: FittedSet, after: FittedSet, told: bool = False) -> Improvement:
        """Of what is left out.

        Args:
            told: only where it is told of both, see `FittedSet`.
        """
        some = before.told & after.told if told else np.ones(len(self.block), bool)
        # blocks are numbered without gaps
        _, block = np.unique(self.block[some], return_inverse=True)
        pair = before.left_out[some], after.left_out[some]
        return improvement(*pair, block, np.random.default_rng(SEED))

    def earns(self, before: FittedSet, after: FittedSet, least: float = MATERIAL) -> bool:
        """Whether what `after` has more than `before` earns its place, in all and where it is told.

        Args:
            least: share of the error by which it must fall.
        """
        gains = (self.improvement(before, after, told) for told in (False, True))
        return all(gain.lower > 0 and gain.fraction >= least for gain in gains)

    def takes(self, before: FittedSet, after: FittedSet, least: float = MATERIAL) -> bool:
        """Whether `after` takes the place of `before`.

        What has more numbers must earn them. Of as many, what has surely less error is better,
        however little; of fewer, what is as near and does not lack what `before` has.

        Args:
            least: share of the error by which more numbers must let it fall.
        """
        if after.complexity > before.complexity:
            return self.earns(before, after, least)
        if after.complexity == before.complexity:
            return self.earns(before, after, 0.0)
        near = after.left_out_rmse <= AT_THE_FLOOR * before.left_out_rmse
        return near and not self.misses(before, after)

    def ties(self, one: FittedSet, other: FittedSet) -> bool:
        """Whether `other` explains as well by other names, with one number more at most."""
        if one.names == other.names or other.complexity > one.complexity + 1:
            return False
        near = self.alike(other.left_out_rmse, one.left_out_rmse)
        return near and not self.earns(other, one, 0.0)

    def misses(self, before: FittedSet, after: FittedSet) -> bool:
        """Whether `after`, of fewer numbers, lacks what `before` has.

        A block of time that only one of them explains is often not drawn, so that chance cannot be
        excluded; so an error that is much larger needs no such proof, nor does one that is more
        than noise where there was only noise.
        """
        errors = before.left_out_rmse, after.left_out_rmse
        larger = errors[1] > PROMISING * errors[0]
        beyond = self.quiet(errors[0]) and not self.quiet(errors[1], as_it_came=True)
        return larger or beyond or self.earns(after, before)

    def alike(self, error: float, best: float) -> bool:
        """Whether an RMS error is as good as another: within a tie of it, or noise alone."""
        return error <= max((1 + TIED) * best, AT_THE_FLOOR * self.noise_rad)
