"""A learned torque while it is fitted: a sum of basis functions, with weights as parameters."""

from collections.abc import Callable, Sequence

import numpy as np

from t2l.effects.armature import LIGHTEST, add_armature
from t2l.effects.effect import Effect, Parameter
from t2l.effects.law import HAS, INERTIA, LIMIT, PHASE, SIGNED, TENDON, Curve, Law
from t2l.effects.learned import (
    LearnedTorque,
    acting,
    looked_up,
    order,
    places,
    reach_of,
)
from t2l.effects.term import Layout

# of a period: a thousandth over a hundred periods is a tenth of one
STRETCH = Parameter("stretch", "1", -0.1, 0.1, "of the period, as a share", size=1e-3)
# bound: of a ratio, of one sign: beyond, a tendon acts on one joint
LEAST_RATIO, MOST_RATIO = 1e-3, 1e3
RATIO_SIZE = 0.3  # numerics: as of the coupling of two joints
POINTS = 12  # numerics: of a table, in each interval


class SplineTorque(Effect):
    """A law as a sum of basis functions whose weights are fitted.

    Of a curve over a phase the period is fitted too, as the last parameter: its stretch. Of a
    tendon it is the change of the ratio.

    Args:
        law: what acts where.
        grid: (g,) values of the variable, equally spaced.
        basis: (g, k) the basis functions there.
        size: of a torque that makes a difference, in the law's `torque_unit`.
        shown: ends of the variable in the recordings; by default those of the grid.
        atoms: (a, k) weights at one of which a fit begins, of a law that is not zero at first.
        ratio: of the lever arms of a tendon, as of `Curve`.
        breaks: of a spline, between whose intervals its basis has its knots.
        bend: of second differences of the weights, in parts of `size`, what is usual.
    """

    names_joints = True
    summary = LearnedTorque.summary
    signature = LearnedTorque.signature
    source = LearnedTorque.source

    def __init__(
        self,
        law: Law,
        grid: np.ndarray,
        basis: np.ndarray,
        size: float,
        shown: tuple[float, float] | None = None,
        atoms: np.ndarray | None = None,
        ratio: float = 0.0,
        breaks: np.ndarray | None = None,
        bend: float = 1.0,
    ):
        self.law, self.grid, self.basis, self.atoms = law, grid, basis, atoms
        self.breaks, self.bend = breaks, bend
        self.ratio = ratio
        self.shown = shown or (float(grid[0]), float(grid[-1]))
        self.name, self.needs, self.order = law.name, law.needs, order(law)
        self.title = law.words
        self.does_too = HAS.get((law.kind, law.follows), ()) if law.of == law.joint else ()
        self.remembers = False
        # bound: more than any motor gives
        least, unit = -1e6 if law.kind in SIGNED else 0.0, law.torque_unit or "1"
        self.parameters = tuple(
            Parameter(f"weight_{k}", unit, least, 1e6, "of a basis function", size=size)
            for k in range(basis.shape[1])
        )
        if law.follows == PHASE:
            self.parameters = (*self.parameters, STRETCH)
        if law.kind == TENDON:
            # of one sign: a ratio of zero is no tendon
            ends = np.sort(np.sign(ratio) * np.array([LEAST_RATIO, MOST_RATIO])) - ratio
            change = "by which that of the lever arms changes"
            own = Parameter("ratio", "1", *ends.tolist(), change, size=RATIO_SIZE)
            self.parameters = (*self.parameters, own)

        rows = bends(self) / (bend * size)
        self.prior = np.concatenate(
            [rows, np.zeros((len(rows), len(self.parameters) - basis.shape[1]))], axis=1
        )

    def made_of(self) -> dict:
        """The arguments that made it, but for the law."""
        size = self.parameters[0].size
        names = ("grid", "basis", "shown", "atoms", "ratio", "breaks", "bend")
        return {"size": size} | {name: getattr(self, name) for name in names}

    def bending(self, bend: float) -> "SplineTorque":
        """The same where weights bend usually as much."""
        return SplineTorque(self.law, **self.made_of() | {"bend": bend})

    def starts(self, scales):
        own = self.atoms if self.atoms is not None else np.zeros((1, self.basis.shape[1]))
        zeros = np.zeros(len(self.parameters) - own.shape[1])
        return [
            {
                p.name: np.full(len(scales.torque), value)
                for p, value in zip(self.parameters, [*atom, *zeros], strict=True)
            }
            for atom in own
        ]

    def places(self, joints):
        return (tuple(joints).index(self.law.joint),)

    def curve(self, values: Sequence[float]) -> Curve:
        """The curve that values of the parameters make, over the range of the recordings."""
        count = self.basis.shape[1]
        weights, rest = np.asarray(values[:count], float), values[count:]
        law, grid = self.law, self.grid
        at = grid[self.points]
        torque = self.shape @ weights
        if law.kind == LIMIT:
            # beyond its no-load speed a motor brakes; at rest and against the motion none is driven
            until = np.searchsorted(at, 0.0) + 1
            torque[:until] = np.maximum(torque[:until], 0.0)
        at = at[0] + (at - at[0]) * (1 + (sum(rest) if law.follows == PHASE else 0.0))
        ratio = self.ratio + (sum(rest) if law.kind == TENDON else 0.0)
        return Curve(law, tuple(at.tolist()), tuple(torque.tolist()), ratio)

    @property
    def shape(self) -> np.ndarray:
        """(n, k) that makes the values of the curve's table of weights."""
        return self.basis[self.points]

    @property
    def points(self) -> np.ndarray:
        """Indices of the grid that a table shows: where the recordings were."""
        if len(self.grid) == 2:
            return np.arange(2)
        if self.law.given:
            knots = _breaks(self)
            parts = np.arange(POINTS * (len(knots) - 1) + 1) / POINTS
            return np.round(np.interp(parts, np.arange(len(knots)), knots)).astype(int)
        first, last = np.searchsorted(self.grid, self.shown)
        count = POINTS * max(self.basis.shape[1] - 3, 1) + 1
        return np.round(np.linspace(first, min(last, len(self.grid) - 1), count)).astype(int)

    def install(self, loop, rows, joints, values):
        count = self.basis.shape[1]
        weights = np.concatenate([values[p.name] for p in self.parameters[:count]], axis=1)
        stretch = values[STRETCH.name][:, 0] if self.law.follows == PHASE else 0.0
        ratio = self.ratio + values["ratio"][:, 0] if self.law.kind == TENDON else 0.0
        if self.law.kind == INERTIA:
            per_weight = np.ptp(self.basis[:, 0]) / np.ptp(self.grid)
            add_armature(loop, rows, joints, per_weight * weights, LIGHTEST)
        else:
            # a table for each row pays where it is asked at many ticks
            if len(loop.schedule.commands) > 1:
                tables = weights @ self.basis.T
                looked_up(loop, rows, self.law, self.grid, tables, stretch, ratio)
                return
            length = reach_of(self.grid, stretch)
            says = _sum(self.basis, weights, places(self.grid, length))
            acting(loop, rows, self.law, says, ratio, turn=(self.grid[0], length))


def _sum(basis: np.ndarray, weights: np.ndarray, find: Callable) -> Callable:
    """What weights (nrow, k) make of a basis (g, k), of the variable (nrow,)."""

    def says(x: np.ndarray) -> np.ndarray:
        below, part = find(x)
        values = np.einsum("...nk,nk->...n", basis[below], weights)
        return values + part * (np.einsum("...nk,nk->...n", basis[below + 1], weights) - values)

    return says


def weights_of(layout: Layout, effect: SplineTorque) -> np.ndarray:
    """Indices of a law's weights in a layout."""
    slots = [i for i, s in enumerate(layout.slots) if s.term.effect.name == effect.name]
    return np.array(slots[: effect.basis.shape[1]], int)


def bends(effect: SplineTorque) -> np.ndarray:
    """(m, k) that makes second differences of weights: what a straight line has none of.

    Where few samples were, neighbours say what a weight is (Eilers and Marx, Flexible smoothing
    with B-splines and penalties, 1996).
    """
    count = effect.basis.shape[1]
    if count == 1:
        return np.zeros((0, 1))
    if effect.law.given:
        step = np.diff(_breaks(effect))
        slopes = np.diff(np.eye(count), axis=0) * (step.mean() / step)[:, None]
        return np.diff(slopes, axis=0)
    if effect.law.follows == PHASE:
        return np.roll(np.eye(count), 1, axis=0) - 2 * np.eye(count) + np.roll(np.eye(count), -1, 0)
    return np.diff(np.eye(count), 2, axis=0)


def _breaks(effect: SplineTorque) -> np.ndarray:
    """(k,) indices of the grid where a broken line breaks, and of its ends."""
    return effect.basis.argmax(axis=0)
