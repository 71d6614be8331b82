"""A model with more terms: where its fit begins, and what it left."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from t2l.detective.screen import ALIKE, TINY, independent
from t2l.effects.term import Layout, Slot, Term
from t2l.identify.levels import MATERIAL

NOT_ZERO = 1e-9  # numerics: of a parameter's scale

# a model, and what it leaves of the fitted samples on every tick
Known = tuple[tuple[Layout, np.ndarray], np.ndarray]


@dataclass(frozen=True)
class Start:
    """Where a fit begins.

    Attributes:
        layout, u: all terms and their parameters.
        columns: derivatives (nsample,) of the fitted samples along the motion, by slot key, where
            they are known.
        beyond: likewise, what those of a simulation have beyond them.
        unmoved: (n,) where it may begin instead, with what is added beside unmoved other numbers.
    """

    layout: Layout
    u: np.ndarray
    columns: dict[tuple, np.ndarray] = field(default_factory=dict)
    beyond: dict[tuple, np.ndarray] = field(default_factory=dict)
    unmoved: np.ndarray | None = None


def names_of(layout: Layout) -> set[tuple[str, tuple[int, ...]]]:
    """Effects and the joints that have them."""
    return {(term.effect.name, term.joints) for term in layout.terms}


def least_of_no_more(errors: Sequence[float], layouts: Sequence[Layout]) -> list[float]:
    """For each of some sets the least error of those with no more effects."""
    sizes = [len(layout.terms) for layout in layouts]
    pairs = [*zip(errors, sizes, strict=True)]
    return [min(error for error, n in pairs if n <= size) for size in sizes]


@dataclass(frozen=True)
class FittedSet:
    """A model with more terms, fitted.

    Attributes:
        layout, u: all terms and their parameters.
        residual: (nsample,) of the fitted samples, rad, predicted minus measured.
        left_out: (nsample,) likewise, each fold by a fit to the others, where these tell what the
            model says; elsewhere, as beyond the positions of a curve that they went to, as fitted.
            Of samples that are left out in several ways the RMS, which has no sign.
        told: (nsample,) bool, where they tell.
        jacobian: (nsample, n).
        free: (n,) bool, which were fitted.
        phases: how many were fitted, one of each recording and joint that swings.
        beyond: see `Start`.
    """

    layout: Layout
    u: np.ndarray
    residual: np.ndarray
    left_out: np.ndarray
    told: np.ndarray
    jacobian: np.ndarray
    free: np.ndarray
    phases: int = 0
    beyond: dict[tuple, np.ndarray] = field(default_factory=dict)

    @property
    def model(self) -> tuple[Layout, np.ndarray]:
        """Layout and u."""
        return self.layout, self.u

    @property
    def known(self) -> "Known":
        """The model with what it leaves."""
        return self.model, self.residual

    @property
    def rmse(self) -> float:
        """Of the fitted samples."""
        return float(np.sqrt(np.mean(self.residual**2)))

    @property
    def left_out_rmse(self) -> float:
        """What decides."""
        return float(np.sqrt(np.mean(self.left_out**2)))

    @cached_property
    def complexity(self) -> int:
        """How many numbers the samples tell of those that were chosen; a name counts as one.

        What joints may share counts as one where values of their own do not matter.
        """
        fixed = self.layout.lower >= self.layout.upper
        rough = int((~self.free & ~fixed).sum())
        own, of = np.unique(self._alike, return_inverse=True)
        shared = np.eye(len(own))[of]
        together = shared.T @ self._products @ shared
        # what cancels between joints that share it moves nothing
        moves = np.diag(together) > ALIKE * (shared.T @ np.diag(self._products))
        told = independent(together[np.ix_(moves, moves)])
        return told + rough + self.phases + len(self.layout.terms)

    @cached_property
    def _products(self) -> np.ndarray:
        jacobian = self.jacobian[:, self.free]
        return jacobian.T @ jacobian

    @property
    def _fitted_slots(self) -> list[Slot]:
        return [self.layout.slots[i] for i in np.flatnonzero(self.free)]

    @cached_property
    def _alike(self) -> np.ndarray:
        """Of each number that was fitted the first of those that it is alike to."""
        allowed = ((1 + MATERIAL) ** 2 - 1) * float(self.residual @ self.residual)
        return alike(self._fitted_slots, self.u[self.free], self._products, allowed)

    def shares(self, term: Term) -> bool:
        """Whether all joints of a term have the same numbers, or as good as that."""
        own = zip(self._fitted_slots, self._alike, strict=True)
        found = {(slot.parameter.name, i) for slot, i in own if slot.term is term}
        return len(term.joints) > 1 and len(found) <= len({name for name, _ in found})

    @property
    def columns(self) -> dict[tuple, np.ndarray]:
        """Of the Jacobian along the motion, by slot key."""
        keys = ((i, slot.key) for i, slot in enumerate(self.layout.slots) if self.free[i])
        return {key: self.jacobian[:, i] - self.beyond.get(key, 0.0) for i, key in keys}

    @property
    def names(self) -> set[tuple[str, tuple[int, ...]]]:
        """Effects and the joints that have them."""
        return names_of(self.layout)


def alike(slots: Sequence[Slot], u: np.ndarray, products: np.ndarray, allowed: float) -> np.ndarray:
    """(n,) of each of some numbers u (n,) the first of those that one number may stand for.

    That is a parameter of several joints, if it has no scale that is a joint's own.

    Args:
        products: (n, n) of the derivatives by u.
        allowed: by how much the sum of squares may rise.
    """
    n = len(slots)
    groups: dict[tuple, list[int]] = {}
    for i, slot in enumerate(slots):
        groups.setdefault((*slot.key[:2], slot.parameter.scale and slot.joint), []).append(i)
    size = np.sqrt(np.diag(products)) + TINY
    inverse = np.linalg.pinv(products / np.outer(size, size), ALIKE, hermitian=True)
    ties, of = np.zeros((0, n)), np.arange(n)
    for group in groups.values():
        more = (np.eye(n)[group[1:]] - np.eye(n)[group[0]]) / size
        both = np.concatenate([ties, more])
        apart = both @ (size * u)
        rise = apart @ np.linalg.pinv(both @ inverse @ both.T, hermitian=True) @ apart
        if rise <= allowed:
            ties, of[group] = both, group[0]
    return of


def sizes(start: Start) -> np.ndarray:
    """(n,) of a change of each element that makes a difference."""
    stated = np.array([s.size for s in start.layout.slots])
    return np.maximum(np.maximum(np.abs(start.u), stated), least_sizes(start.layout))


def least_sizes(layout: Layout) -> np.ndarray:
    """(n,) in place of a size of zero."""
    return NOT_ZERO * np.array([slot.scale for slot in layout.slots])
