"""Which few effects explain an error together, and how surely: linear algebra on responses.

What the simulation does in response to an effect are the atoms of a dictionary: how far the
effect's own fit moved the prediction, and the derivatives there. The atoms of one effect are a
group, taken or left as a whole. On a resample of blocks of time, groups are selected forward, with
backward elimination after each (Efroymson, Multiple regression analysis, 1960); the blocks that
were not drawn judge. How often a group is selected over many resamples, or serves as well as one
that is, says how stable the choice is (Meinshausen and Bühlmann, Stability selection, 2010).
Nothing is simulated here.
"""

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from t2l.diagnose.settings import LEAST_BLOCKS, MOST_EFFECTS, SELECTIONS
from t2l.identify.levels import MATERIAL

RIDGE = 1e-9  # numerics: of a column's square: keeps what columns share at a finite coefficient
SEED = 0  # statistics: of the resamples


@dataclass(frozen=True)
class Group:
    """The responses to one effect.

    Attributes:
        name: the effect's.
        atoms: (nsample, k) rad.
        parameters: how many numbers the effect has; of two that explain alike the fewer win.
        excludes: groups that it contains, or that contain it.
    """

    name: str
    atoms: np.ndarray
    parameters: int
    excludes: frozenset[str] = frozenset()


class Dictionary:
    """Groups of responses, and a residual to explain with few of them."""

    def __init__(
        self,
        target: np.ndarray,
        base: np.ndarray,
        groups: Sequence[Group],
        block: np.ndarray,
    ):
        """Products of all columns within each block are all that is kept.

        Args:
            target: (nsample,) rad, what the responses are to add up to.
            base: (nsample, b) responses that are always taken: those of the model so far.
            block: (nsample,) which block of time a sample belongs to.
        """
        self.groups = {group.name: group for group in groups}
        columns = np.column_stack([base, *(group.atoms for group in groups), target])
        size = np.sqrt(np.mean(columns**2, axis=0))
        columns /= np.where(size > 0, size, 1.0)
        ends = np.cumsum([base.shape[1], *(group.atoms.shape[1] for group in groups)])
        self.base = np.arange(base.shape[1])
        self.index = {
            group.name: np.arange(first, last)
            for group, first, last in zip(groups, ends[:-1], ends[1:], strict=True)
        }
        order = np.argsort(block, kind="stable")
        starts = np.flatnonzero(np.diff(block[order], prepend=-1))
        self.products = np.stack([p.T @ p for p in np.split(columns[order], starts[1:])])

    def shares(self) -> dict[str, float | None]:
        """By group, in what share of the resamples it explains as well as anything.

        It is selected there, or serves as well in place of one that is: else alike effects would
        split the choice among them. None where there are fewer blocks than `LEAST_BLOCKS`.
        """
        served = [self._serving(self.select(drawn), drawn) for drawn in self.resamples()]
        counts = Counter(name for names in served for name in names)
        return {name: counts[name] / len(served) if served else None for name in self.groups}

    def resamples(self) -> Iterator[np.ndarray]:
        """(nblock,) how often each block is drawn, `SELECTIONS` times at most."""
        rng, count = np.random.default_rng(SEED), len(self.products)
        if count < LEAST_BLOCKS:
            return
        for _ in range(SELECTIONS):
            drawn = np.bincount(rng.integers(0, count, count), minlength=count)
            if (drawn == 0).any():
                yield drawn

    def select(self, drawn: np.ndarray) -> tuple[str, ...]:
        """Forward selection with backward elimination: fitted to blocks as often as drawn.

        Args:
            drawn: (nblock,) how often; those with zero judge.

        Returns:
            The names, sorted.
        """
        fitted, judging = self._sides(drawn)
        chosen: list[str] = []
        error = self._error(chosen, fitted, judging)
        while len(chosen) < MOST_EFFECTS:
            errors = {
                name: self._error([*chosen, name], fitted, judging)
                for name, group in self.groups.items()
                if name not in chosen and not group.excludes & set(chosen)
            }
            earning = {n: e for n, e in errors.items() if e <= (1 - MATERIAL) * error}
            if not earning:
                break
            name = self._simplest(earning)
            chosen, error = [*chosen, name], errors[name]
            # below what was left before it was added, so that no set comes a second time
            limit = error / (1 - MATERIAL)
            for other in chosen[:-1]:
                rest = [c for c in chosen if c != other]
                without = self._error(rest, fitted, judging)
                if without < limit:
                    chosen, error = rest, without
        return tuple(sorted(chosen))

    def _serving(self, chosen: tuple[str, ...], drawn: np.ndarray) -> set[str]:
        """What was selected, and what serves as well in place of one of it."""
        sides = self._sides(drawn)
        error, serving = self._error(chosen, *sides), set(chosen)
        for other in chosen:
            rest = [name for name in chosen if name != other]
            # nearly all that the selected one takes off
            limit = error + MATERIAL * (self._error(rest, *sides) - error)
            serving |= {
                name
                for name, group in self.groups.items()
                if name not in serving
                and not group.excludes & set(rest)
                and self._error([*rest, name], *sides) <= limit
            }
        return serving

    def _sides(self, drawn: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Products of the columns in the blocks that are fitted, and in those that judge."""
        fitted = np.tensordot(drawn.astype(float), self.products, 1)
        return fitted, np.tensordot((drawn == 0).astype(float), self.products, 1)

    def _simplest(self, errors: dict[str, float]) -> str:
        limit = min(errors.values()) / (1 - MATERIAL)
        alike = [name for name, error in errors.items() if error <= limit]
        return min(alike, key=lambda name: (self.groups[name].parameters, errors[name]))

    def _error(self, names: Sequence[str], fitted: np.ndarray, judging: np.ndarray) -> float:
        """Root of the sum of squares left in the judging blocks."""
        at = np.concatenate([self.base, *(self.index[name] for name in names)]).astype(int)
        normal = fitted[np.ix_(at, at)]
        normal = normal + RIDGE * max(np.trace(normal), 1e-300) * np.eye(len(at))
        weights = np.linalg.solve(normal, fitted[at, -1])
        left = judging[-1, -1] - 2 * weights @ judging[at, -1]
        return float(np.sqrt(max(left + weights @ judging[np.ix_(at, at)] @ weights, 0.0)))
