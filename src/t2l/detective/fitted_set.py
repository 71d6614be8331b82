"""A model with more terms: where its fit begins, and what it left."""

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from t2l.detective.screen import independent
from t2l.effects.term import Layout

NOT_ZERO = 1e-9  # numerics: of a parameter's scale

# a model, and what it leaves of the fitted samples on every tick
Known = tuple[tuple[Layout, np.ndarray], np.ndarray]


@dataclass(frozen=True)
class Start:
    """Where a fit begins.

    Attributes:
        layout, u: all terms and their parameters.
        columns: derivatives (nsample,) of the fitted samples, by slot key, where they are known.
    """

    layout: Layout
    u: np.ndarray
    columns: dict[tuple, np.ndarray] = field(default_factory=dict)


def names_of(layout: Layout) -> set[tuple[str, tuple[int, ...]]]:
    """Effects and the joints that have them."""
    return {(term.effect.name, term.joints) for term in layout.terms}


@dataclass(frozen=True)
class FittedSet:
    """A model with more terms, fitted.

    Attributes:
        layout, u: all terms and their parameters.
        residual: (nsample,) of the fitted samples, rad, predicted minus measured.
        left_out: (nsample,) likewise, each fold by a fit to the others, where these tell what the
            model says; elsewhere, as beyond the positions of a curve that they went to, as fitted.
        told: (nsample,) bool, where they tell.
        jacobian: (nsample, n).
        free: (n,) bool, which were fitted.
    """

    layout: Layout
    u: np.ndarray
    residual: np.ndarray
    left_out: np.ndarray
    told: np.ndarray
    jacobian: np.ndarray
    free: np.ndarray

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
        """How many numbers the samples tell of those that were chosen; a name counts as one."""
        fixed = self.layout.lower >= self.layout.upper
        rough = int((~self.free & ~fixed).sum())
        told = independent(self.jacobian[:, self.free].T @ self.jacobian[:, self.free])
        return told + rough + len(self.layout.terms)

    @property
    def columns(self) -> dict[tuple, np.ndarray]:
        """Of the Jacobian, by slot key."""
        keys = (slot.key for slot in self.layout.slots)
        return {key: self.jacobian[:, i] for i, key in enumerate(keys) if self.free[i]}

    @property
    def names(self) -> set[tuple[str, tuple[int, ...]]]:
        """Effects and the joints that have them."""
        return names_of(self.layout)


def sizes(start: Start) -> np.ndarray:
    """(n,) of a change of each element that makes a difference."""
    stated = np.array([s.size for s in start.layout.slots])
    return np.maximum(np.maximum(np.abs(start.u), stated), least_sizes(start.layout))


def least_sizes(layout: Layout) -> np.ndarray:
    """(n,) in place of a size of zero."""
    return NOT_ZERO * np.array([slot.scale for slot in layout.slots])
