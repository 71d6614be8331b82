"""Sets of candidates scored by the error of the linear model on recordings that were left out.

Of every complexity the best sets are kept: a front of error against size. Sets grow by
one candidate at a time from several beginnings (beam search); what a later one made superfluous is
dropped and members are exchanged. All that is needed of the columns are their products, by fold.

Source: beam search over models, Hastie et al., The elements of statistical learning, 2009, section
3.3 (forward and backward selection); leave-one-out as of section 7.10.
"""

from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import combinations, islice

import numpy as np

from t2l.detective.candidates import Candidate, Table, do_the_same

RIDGE = 1e-6  # numerics: of a column's sum of squares: keeps what is alike at a finite weight
TINY = 1e-100  # numerics: keeps what does nothing solvable, in any unit
PARSIMONY = 0.01  # tuned: of the squared error, for each number
WIDTH = 6  # numerics: sets that go on at each size
# numerics: of the candidates to add, the most promising, that are scored in full; of each its best
LOOKED_AT, SETTINGS = 30, 2
MOST = 5  # bound: candidates in a set
FIXINGS = 4  # numerics: times that what lies outside is fixed at its bound, and the rest solved
SWEEPS = 10  # numerics: of coordinate descent within bounds then
ALIKE = 1e-5  # numerics: of a sum of squares: columns that differ by less are one
SETTLED = 1e-4  # numerics: relative change of a sweep that is none


@dataclass(frozen=True)
class Scored:
    """A set with its error.

    Attributes:
        complexity: how many numbers it fits, names counted too.
        error: mean squared error on what was left out, rad².
    """

    members: tuple[int, ...]
    complexity: int
    error: float


@dataclass
class Screen:
    """Products of columns and residual by fold, and the scores of sets.

    Attributes:
        folds: (nsample, k) numbers of the parts that each sample is left out with, in k ways.
        noise_rad: of a sample, that the priors of candidates are weighed by.
        products: (nfold, m + 1, m + 1) of all columns and the residual, by fold.
        numbers: how many each candidate fits, its name counted too.
    """

    table: Table
    residual: np.ndarray
    folds: np.ndarray
    noise_rad: float = 0.0
    products: np.ndarray | None = None
    numbers: list[int] | None = None

    def __post_init__(self) -> None:
        self.count = len(self.residual)
        if self.products is None:
            columns = np.column_stack([self.table.columns, self.residual])
            self.products = products_of(columns, self.folds)
        number = np.unique(self.folds)
        self.ways = [np.searchsorted(number, np.unique(way)) for way in self.folds.T]
        self.prior = self._prior()
        whole = self._all(self.products)
        self.total = whole + self.prior
        self.known: dict[frozenset[int], Scored] = {}
        if self.numbers is None:
            self.numbers = [_numbers(one, self.table, whole) for one in self.table.candidates]
        # candidates by how many constants and columns they have
        alike: dict[tuple[int, int], list[int]] = {}
        for i in range(len(self.table.candidates)):
            alike.setdefault(self._width((i,)), []).append(i)
        self._alike = [
            (
                rows,
                np.array([self.table.candidates[i].constants for i in rows], int),
                np.array([[c.at for c in self.table.candidates[i].columns] for i in rows], int),
            )
            for rows in alike.values()
        ]

    def _all(self, of_parts: np.ndarray) -> np.ndarray:
        """Of all samples, of what is a sum (nfold, ...) over those of each part."""
        return of_parts.sum(axis=0) / self.folds.shape[1]

    def _others(self, of_parts: np.ndarray) -> np.ndarray:
        """Of all samples but those of each part, of sums (n, nfold, ...) over those of each."""
        others = np.empty_like(of_parts)
        for of in self.ways:
            others[:, of] = of_parts[:, of].sum(axis=1, keepdims=True) - of_parts[:, of]
        return others

    def _prior(self) -> np.ndarray:
        """Products of what is known of the columns whatever is left out."""
        table, products = self.table, np.zeros(self.products.shape[1:])
        known = [(*candidate.prior, 0.0) for candidate in table.candidates]
        for at, rows, tending in [*known, (table.base, table.prior, table.tending)]:
            if len(rows):
                products[np.ix_(at, at)] += rows.T @ rows
                products[at, -1] += rows.T @ np.broadcast_to(tending, len(rows))
        return self.noise_rad**2 * products

    def beside(
        self,
        kept: Sequence[int],
        derivatives: np.ndarray,
        limits: tuple[np.ndarray, np.ndarray, np.ndarray],
        residual: np.ndarray,
    ) -> "Screen":
        """Of what may be added to another model.

        Args:
            kept: which candidates may be.
            derivatives: (nsample, p) of that model, which every set has.
            limits: `bounds`, `prior` and `tending` of its parameters, see `Table`.
            residual: (nsample,) measured minus what it predicts.
        """
        first = self.table.columns.shape[1]
        own = _finite(np.column_stack([derivatives, residual]))
        every = first + own.shape[1]
        products = np.empty((len(self._parts), every, every))
        products[:, :first, :first] = self.products[:, :first, :first]
        for of, (rows, columns) in zip(products, self._parts, strict=True):
            here = own[rows]
            of[:first, first:] = columns.T @ here
            of[first:, :first] = of[:first, first:].T
            of[first:, first:] = here.T @ here
        candidates = [self.table.candidates[i] for i in kept]
        base = tuple(range(first, every - 1))
        table = Table(self.table.columns, candidates, base, *limits)
        numbers = [self.numbers[i] for i in kept]
        return Screen(table, residual, self.folds, self.noise_rad, products, numbers)

    @cached_property
    def _parts(self) -> list[tuple[np.ndarray, np.ndarray]]:
        return _by_fold(self.table.columns, self.folds)

    def score(self, members: Sequence[int]) -> Scored:
        """Of a set of indices of candidates."""
        return self.scores([members])[0]

    def scores(self, sets: Sequence[Sequence[int]]) -> list[Scored]:
        """Of many sets; those of as many columns are solved together."""
        keys = [frozenset(members) for members in sets]
        alike: dict[tuple[int, int], list[frozenset[int]]] = {}
        for key in dict.fromkeys(keys):
            if key not in self.known:
                alike.setdefault(self._width(key), []).append(key)
        for some in alike.values():
            for key, error in zip(some, self._left(some), strict=True):
                members, count = tuple(sorted(key)), self._count(key)
                penalised = error * (1 + PARSIMONY * count) / self.count
                self.known[key] = Scored(members, count, float(penalised))
        return [self.known[key] for key in keys]

    def chosen(self, members: Sequence[int]) -> list[Candidate]:
        """The candidates of a set."""
        return [self.table.candidates[i] for i in members]

    def weights(self, members: Sequence[int]) -> np.ndarray:
        """Of what is kept of the base's and of the set's columns, fitted to all."""
        constants, at, lower, upper = self._columns(members)
        return self._solve(self.total, constants, at, lower, upper)[0]

    def kept(self, members: Iterable[int]) -> list[int]:
        """Of the base's columns those that a set does not take away, as places in the base."""
        gone = {k for i in members for k in self.table.candidates[i].without}
        return [k for k in range(len(self.table.base)) if k not in gone]

    def _count(self, members: Iterable[int]) -> int:
        return sum(self.numbers[i] for i in members)

    def _width(self, members: Iterable[int]) -> tuple[int, int]:
        chosen = [self.table.candidates[i] for i in members]
        columns = sum(len(one.columns) - len(one.without) for one in chosen)
        return sum(len(one.constants) for one in chosen), columns

    def _columns(self, members: Iterable[int]):
        """Constants (k,), columns (p,) with those of the base, and their bounds."""
        chosen = [self.table.candidates[i] for i in members]
        constants = np.array([c for one in chosen for c in one.constants], int)
        columns = [c for one in chosen for c in one.columns]
        kept = self.kept(members)
        at = np.array([*(self.table.base[k] for k in kept), *(c.at for c in columns)], int)
        lower = np.array([*self.table.bounds[kept, 0], *(c.lower for c in columns)])
        upper = np.array([*self.table.bounds[kept, 1], *(c.upper for c in columns)])
        return constants, at, lower, upper

    def _left(self, sets: Sequence[Iterable[int]]) -> np.ndarray:
        """Squared error on what was left out, of sets of equal width."""
        # what a set needs of the products: (nset, nfold, k + p + 1, k + p + 1)
        parts = [self._columns(members) for members in sets]
        constants, at, lower, upper = (np.array(values) for values in zip(*parts, strict=True))
        last = np.full((len(sets), 1), self.products.shape[-1] - 1)
        whole = np.concatenate([constants, at, last], axis=1)
        products = self.products[:, whole[:, :, None], whole[:, None, :]].swapaxes(0, 1)
        k, p = constants.shape[1], at.shape[1]
        vector = np.zeros((*products.shape[:2], k + p + 1))
        vector[..., :k], vector[..., -1] = -1.0, 1.0
        if p:
            prior = self.prior[whole[:, :, None], whole[:, None, :]][:, None]
            others = self._others(products) + prior
            of = slice(k, k + p)
            target = others[..., of, -1] - others[..., of, :k].sum(axis=-1)
            every = (len(sets), len(self.products), p)
            bounds = (np.broadcast_to(b[:, None], every).reshape(-1, p) for b in (lower, upper))
            w = bounded(others[..., of, of].reshape(-1, p, p), target.reshape(-1, p), *bounds)
            vector[..., of] = -w.reshape(every)
        errors = np.einsum("sfi,sfij,sfj->sf", vector, products, vector)
        return self._all(np.maximum(errors, 0.0).T)

    def _solve(self, product, constants, at, lower, upper) -> np.ndarray:
        normal = product[np.ix_(at, at)]
        target = product[at, -1] - product[np.ix_(at, constants)].sum(axis=1)
        return bounded(normal[None], target[None], lower[None], upper[None])

    def growing(self, members: Sequence[int]) -> list[int]:
        """Candidates that may be added, the most promising first, bounds left aside."""
        constants, at, _, _ = self._columns(members)
        taken = [self.table.candidates[i] for i in members]
        gone = {one.effect.name for one in taken if one.removal}
        stay = [one for one in self.table.candidates if one.removal and one.effect.name not in gone]
        product = self.total
        vector = np.zeros(len(product))
        vector[-1] = 1.0
        for c in constants:
            vector[c] -= 1.0
        # what is left along each column, and the products of columns with the set's taken off
        along = product @ vector
        square = float(vector @ along)
        across = taken_off = np.zeros((0, len(product)))
        if len(at):
            normal = product[np.ix_(at, at)]
            normal = normal + RIDGE * np.diag(np.diag(normal) + TINY)
            taken_off = product[at]
            across = np.linalg.solve(normal, taken_off)
            w = across @ vector
            square -= float(w @ (taken_off @ vector))
            along = along - w @ taken_off

        def between(a: np.ndarray, b: np.ndarray) -> np.ndarray:
            """Products (g, k, l) of columns a (g, k) and b (g, l), less the set's."""
            both = product[a[:, :, None], b[:, None, :]]
            return both - np.einsum("qgk,qgl->gkl", taken_off[:, a], across[:, b])

        left = np.full(len(self.table.candidates), np.inf)
        for rows, constants, columns in self._alike:
            error = square - 2 * along[constants].sum(axis=1)
            error += between(constants, constants).sum(axis=(1, 2))
            target = along[columns] - between(columns, constants).sum(axis=2)
            normal = between(columns, columns)
            ridge = RIDGE * np.diagonal(product)[columns] + TINY
            normal = normal + ridge[..., None] * np.eye(columns.shape[1])
            w = np.linalg.solve(normal, target[..., None])[..., 0]
            left[rows] = error - (target * w).sum(axis=1)
        left *= 1 + PARSIMONY * np.array(self.numbers)
        free = (
            int(i) for i in np.argsort(left, kind="stable")
            if not self.table.candidates[i].removal
            and not any(_excludes(self.table.candidates[i], other) for other in taken)
            and not any(do_the_same(self.table.candidates[i], other) for other in stay)
        )  # fmt: skip
        return list(islice(self._best_settings(free), LOOKED_AT))

    def _best_settings(self, ranked: Iterable[int]) -> Iterator[int]:
        """Of candidates, the most promising first, the first few settings of each."""
        seen: Counter = Counter()
        for i in ranked:
            one = self.table.candidates[i]
            version = *one.key, len(one.columns)
            seen[version] += 1
            if seen[version] <= SETTINGS:
                yield i

    def search(self) -> list[Scored]:
        """The front: of every complexity the best set, if it is better than all less.

        Sets grow from nothing, and from the model less one term or two of its own.
        """
        removals = [i for i, one in enumerate(self.table.candidates) if one.removal]
        beam = self.scores([m for k in (0, 1, 2) for m in combinations(removals, k)])
        for _ in range(MOST):
            grown: dict[frozenset[int], Scored] = {}
            for one in beam:
                more = [(*one.members, i) for i in self.growing(one.members)]
                better = (found for found in self.scores(more) if found.error < one.error)
                grown |= {frozenset(found.members): found for found in better}
            if not grown:
                break
            ranked = sorted(grown.values(), key=lambda s: s.error)
            beam = ranked[:WIDTH]
            beam += [s for s in self.front(ranked) if s not in beam]
        for one in self.front()[-4:]:
            self._exchange(one)
        return self.front()

    def in_place(self) -> list[Scored]:
        """The model with an effect in the place of each of its terms, on the joints that it needs.

        Effects are tried that alone promise most there. As their settings are first guesses, they
        may leave more than a fit of them will.
        """
        found = []
        for gone, term in enumerate(self.table.candidates):
            promising = self.growing((gone,)) if term.removal else []
            for name in dict.fromkeys(self.table.candidates[i].effect.name for i in promising):
                same = [i for i in promising if self.table.candidates[i].effect.name == name]
                one = self.score((gone,))
                while True:
                    more = self.scores([
                        (*one.members, i) for i in same
                        if not any(_excludes(self.table.candidates[i], self.table.candidates[m])
                                   for m in one.members)
                    ])  # fmt: skip
                    better = min(more, key=lambda s: s.error, default=one)
                    if better.error >= one.error:
                        break
                    one = better
                found.append(one)
        return found

    def front(self, scored: Sequence[Scored] | None = None) -> list[Scored]:
        """Sets that no smaller one is better than."""
        found, least = [], np.inf
        every = self.known.values() if scored is None else scored
        for one in sorted(every, key=lambda s: (s.complexity, s.error)):
            # numerics: what is less
            if one.error < 0.97 * least:
                found.append(one)
                least = one.error
        return found

    def _exchange(self, one: Scored) -> None:
        for _ in range(3):
            moves = [tuple(m for m in one.members if m != gone) for gone in one.members]
            # numerics: of the most promising
            moves += [(*rest, i) for rest in moves for i in self.growing(rest)[:8]]
            best = min(self.scores(moves), key=lambda s: s.error, default=one)
            # numerics: a gain that is none
            if best.error >= 0.999 * one.error:
                return
            one = best


def products_of(columns: np.ndarray, folds: np.ndarray) -> np.ndarray:
    """Products (nfold, m, m) of columns (nsample, m) in each fold; what is not finite is zero.

    Args:
        folds: (nsample, k), see `Screen`.
    """
    return np.array([own.T @ own for _, own in _by_fold(columns, folds)], float)


def _by_fold(columns: np.ndarray, folds: np.ndarray) -> list[tuple[np.ndarray, np.ndarray]]:
    """Of each fold the samples (nsample,) bool, and their columns."""
    columns = _finite(columns)
    rows = ((folds == f).any(axis=1) for f in np.unique(folds))
    return [(some, columns[some]) for some in rows]


def _finite(columns: np.ndarray) -> np.ndarray:
    return np.nan_to_num(columns.astype(np.float32), posinf=0.0, neginf=0.0)


def independent(products: np.ndarray) -> int:
    """How many of some columns are told from each other, from their products (p, p)."""
    if not len(products):
        return 0
    size = np.sqrt(np.diag(products)) + TINY
    values = np.linalg.eigvalsh(products / np.outer(size, size))
    return int((values > ALIKE).sum())


def _numbers(one: Candidate, table: Table, products: np.ndarray) -> int:
    """How many numbers of a candidate the samples tell; its name counts as one."""
    at = [table.base[k] for k in one.without] or [column.at for column in one.columns]
    untold = len(at) - independent(products[np.ix_(at, at)])
    if one.removal:
        return one.complexity + untold
    return one.complexity - (untold if one.numbers <= len(at) else 0)


def _excludes(one: Candidate, other: Candidate) -> bool:
    if one.effect.name != other.effect.name:
        return not (one.removal or other.removal) and do_the_same(one, other)
    # beside what the model has an effect asks for fewer numbers than alone
    return one.removal or other.removal or bool(set(one.joints) & set(other.joints))


def bounded(
    normal: np.ndarray, target: np.ndarray, lower: np.ndarray, upper: np.ndarray
) -> np.ndarray:
    """The w that minimise w·N w/2 − t·w within bounds, by coordinate descent.

    Args:
        normal: (k, p, p), of k problems; the others are (k, p), and so is what is returned.
    """
    if not target.shape[-1]:
        return np.zeros_like(target)
    size = np.sqrt(np.diagonal(normal, axis1=-2, axis2=-1)) + TINY
    scaled = normal / (size[..., :, None] * size[..., None, :]) + RIDGE * np.eye(size.shape[-1])
    goal, lower, upper = target / size, lower * size, upper * size
    w = np.linalg.solve(scaled, goal[..., None])[..., 0]
    outside = np.flatnonzero(((w < lower) | (w > upper)).any(axis=-1))
    if len(outside):
        some = (values[outside] for values in (scaled, goal, lower, upper, w))
        w[outside] = _descended(*some)
    return w / size


def _descended(scaled, goal, lower, upper, w) -> np.ndarray:
    """From what is solved without what is at a bound, by coordinate descent."""
    eye, fixed = np.eye(w.shape[-1], dtype=bool), np.zeros(w.shape, bool)
    for _ in range(FIXINGS):
        outside = (w < lower) | (w > upper)
        if not outside.any():
            break
        fixed |= outside
        w = np.where(fixed, np.clip(w, lower, upper), 0.0)
        target = goal - np.einsum("kij,kj->ki", scaled, w)
        free = np.where(fixed[:, :, None] | fixed[:, None, :], eye, scaled)
        moved = np.linalg.solve(free, np.where(fixed, 0.0, target)[..., None])[..., 0]
        w = np.where(fixed, w, moved)
    w, going = np.clip(w, lower, upper), np.arange(len(w))
    for _ in range(SWEEPS):
        n, g, lo, up, x = (values[going] for values in (scaled, goal, lower, upper, w))
        before = x.copy()
        for i in range(x.shape[-1]):
            step = g[:, i] - np.einsum("kj,kj->k", n[:, i], x)
            x[:, i] = np.minimum(np.maximum(x[:, i] + step / n[:, i, i], lo[:, i]), up[:, i])
        w[going] = x
        moved = np.abs(x - before).max(axis=1) > SETTLED * np.abs(x).max(axis=1)
        going = going[moved]
        if not len(going):
            break
    return w
