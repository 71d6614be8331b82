"""Sets of candidates scored by the error of the linear model on recordings that were left out.

Of every number of parameters the best sets are kept: a front of error against size. Sets grow by
one candidate at a time from several beginnings (beam search); what a later one made superfluous is
dropped and members are exchanged. All that is needed of the columns are their products, by fold.

Source: beam search over models, Hastie et al., The elements of statistical learning, 2009, section
3.3 (forward and backward selection); leave-one-out as of section 7.10.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from t2l.detective.candidates import Candidate, Table

RIDGE = 1e-6  # numerics: of a column's sum of squares: keeps what is alike at a finite weight
PARSIMONY = 0.015  # tuned: of the squared error, for each parameter
WIDTH = 6  # numerics: sets that go on at each size
LOOKED_AT = 30  # numerics: of the candidates to add, the most promising, that are scored in full
MOST = 5  # candidates in a set
SWEEPS = 40  # numerics: of coordinate descent within bounds


@dataclass(frozen=True)
class Scored:
    """A set with its error.

    Attributes:
        parameters: how many numbers it fits.
        error: mean squared error on what was left out, rad².
    """

    members: tuple[int, ...]
    parameters: int
    error: float


@dataclass
class Screen:
    """Products of columns and residual by fold, and the scores of sets.

    Attributes:
        folds: (nsample,) number of the part that each sample is left out with.
    """

    table: Table
    residual: np.ndarray
    folds: np.ndarray

    def __post_init__(self) -> None:
        columns = np.concatenate([self.table.columns, self.residual[:, None]], axis=1)
        columns = np.nan_to_num(columns.astype(np.float32), posinf=0.0, neginf=0.0)
        self.count = len(self.residual)
        self.products = np.stack(
            [columns[self.folds == f].T @ columns[self.folds == f] for f in np.unique(self.folds)]
        ).astype(float)
        self.total = self.products.sum(axis=0)
        self.known: dict[frozenset[int], Scored] = {}

    def score(self, members: Sequence[int]) -> Scored:
        """Of a set of indices of candidates."""
        key = frozenset(members)
        if key not in self.known:
            error, count = self._left(members), self._count(members)
            self.known[key] = Scored(
                tuple(sorted(key)), count, error * (1 + PARSIMONY * count) / self.count
            )
        return self.known[key]

    def chosen(self, members: Sequence[int]) -> list[Candidate]:
        """The candidates of a set."""
        return [self.table.candidates[i] for i in members]

    def weights(self, members: Sequence[int]) -> np.ndarray:
        """Of the base's and the set's columns, fitted to all."""
        constants, at, lower, upper = self._columns(members)
        return self._solve(self.total, constants, at, lower, upper)

    def _count(self, members: Sequence[int]) -> int:
        return sum(self.table.candidates[i].parameters for i in members)

    def _columns(self, members: Sequence[int]):
        chosen = [self.table.candidates[i] for i in members]
        constants = [c for one in chosen for c in one.constants]
        columns = [c for one in chosen for c in one.columns]
        at = np.array([*self.table.base, *(c.at for c in columns)], int)
        lower = np.array([*self.table.bounds[:, 0], *(c.lower for c in columns)])
        upper = np.array([*self.table.bounds[:, 1], *(c.upper for c in columns)])
        return constants, at, lower, upper

    def _left(self, members: Sequence[int]) -> float:
        constants, at, lower, upper = self._columns(members)
        whole, error = np.array([*constants, *at, -1], int), 0.0
        n = len(constants)
        for product in self.products:
            w = self._solve(self.total - product, constants, at, lower, upper)
            vector = np.concatenate([-np.ones(n), -w, [1.0]])
            error += max(float(vector @ product[np.ix_(whole, whole)] @ vector), 0.0)
        return error

    def _solve(self, product, constants, at, lower, upper) -> np.ndarray:
        if not len(at):
            return np.zeros(0)
        normal = product[np.ix_(at, at)]
        target = product[at, -1] - product[np.ix_(at, constants)].sum(axis=1)
        return bounded(normal, target, lower, upper)

    def growing(self, members: Sequence[int]) -> list[int]:
        """Candidates that may be added, the most promising first, bounds left aside."""
        constants, at, _, _ = self._columns(members)
        taken = [self.table.candidates[i] for i in members]
        product = self.total
        vector = np.zeros(len(product))
        vector[-1] = 1.0
        for c in constants:
            vector[c] -= 1.0
        # what is left along each column, and the products of columns with the set's taken off
        along = product @ vector
        square = float(vector @ along)
        reduced = None
        if len(at):
            normal = product[np.ix_(at, at)]
            normal = normal + RIDGE * np.diag(np.diag(normal) + 1e-30)
            across = np.linalg.solve(normal, product[at])
            reduced = product[at], across
            w = across @ vector
            square -= float(w @ (product[at] @ vector))
            along = along - product[:, at] @ w
        scores = []
        for i, candidate in enumerate(self.table.candidates):
            if any(_excludes(candidate, other) for other in taken):
                continue
            scores.append((self._promise(candidate, product, reduced, along, square), i))
        scores.sort()
        return [i for _, i in scores[:LOOKED_AT]]

    def _promise(self, candidate: Candidate, product, reduced, along, square) -> float:
        def between(a, b):
            value = product[np.ix_(a, b)]
            return value if reduced is None else value - reduced[0][:, a].T @ reduced[1][:, b]

        left, constants = square, list(candidate.constants)
        at = [c.at for c in candidate.columns]
        target = along[at]
        if constants:
            left += between(constants, constants).sum() - 2 * along[constants].sum()
            target = target - between(at, constants).sum(axis=1) if at else target
        if at:
            normal = between(at, at)
            normal = normal + RIDGE * np.diag(np.diag(product)[at]) + 1e-30 * np.eye(len(at))
            left -= float(target @ np.linalg.solve(normal, target))
        return left * (1 + PARSIMONY * candidate.parameters)

    def search(self, beginnings: Sequence[tuple[int, ...]] = ((),)) -> list[Scored]:
        """The front: of every number of parameters the best set, if it is better than all less."""
        for begin in beginnings:
            self.score(begin)
        beam = [self.score(begin) for begin in beginnings]
        for _ in range(MOST):
            grown: dict[frozenset[int], Scored] = {}
            for one in beam:
                for i in self.growing(one.members):
                    found = self.score((*one.members, i))
                    if found.error < one.error:
                        grown[frozenset(found.members)] = found
            if not grown:
                break
            ranked = sorted(grown.values(), key=lambda s: s.error)
            beam = ranked[:WIDTH]
            beam += [s for s in self.front(ranked) if s not in beam]
        for one in self.front()[-4:]:
            self._exchange(one)
        return self.front()

    def front(self, scored: Sequence[Scored] | None = None) -> list[Scored]:
        """Sets that no smaller one is better than."""
        found, least = [], np.inf
        every = self.known.values() if scored is None else scored
        for one in sorted(every, key=lambda s: (s.parameters, s.error)):
            if one.error < 0.97 * least:
                found.append(one)
                least = one.error
        return found

    def _exchange(self, one: Scored) -> None:
        for _ in range(3):
            moves = [tuple(m for m in one.members if m != gone) for gone in one.members]
            trials = [self.score(m) for m in moves]
            for rest in moves:
                trials += [self.score((*rest, i)) for i in self.growing(rest)[:8]]
            best = min(trials, key=lambda s: s.error, default=one)
            if best.error >= 0.999 * one.error:
                return
            one = best


def _excludes(one: Candidate, other: Candidate) -> bool:
    return one.effect.name == other.effect.name and bool(set(one.joints) & set(other.joints))


def bounded(
    normal: np.ndarray, target: np.ndarray, lower: np.ndarray, upper: np.ndarray
) -> np.ndarray:
    """The w (p,) that minimises w·N w/2 − t·w within bounds, by coordinate descent."""
    size = np.sqrt(np.diag(normal)) + 1e-15
    scaled = normal / np.outer(size, size) + RIDGE * np.eye(len(size))
    goal, lower, upper = target / size, lower * size, upper * size
    w = np.linalg.solve(scaled, goal)
    if (w >= lower).all() and (w <= upper).all():
        return w / size
    w = np.clip(w, lower, upper)
    for _ in range(SWEEPS):
        before = w.copy()
        for i in range(len(w)):
            step = (goal[i] - scaled[i] @ w) / scaled[i, i]
            w[i] = min(max(w[i] + step, lower[i]), upper[i])
        if np.abs(w - before).max() < 1e-6 * (np.abs(w).max() + 1e-12):
            break
    return w / size
