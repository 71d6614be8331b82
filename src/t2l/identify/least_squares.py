"""Nonlinear least squares by Levenberg and Marquardt's method, with finite differences.

A round simulates some trial steps and the Jacobian's columns around the likeliest of them, so that
one round is usually one iteration. SciPy's `least_squares` runs one fit to its end; here many fits
and trial steps share each batch.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from t2l.effects.term import Layout, Slot
from t2l.identify.levels import MATERIAL
from t2l.identify.optimiser import Optimiser

RELATIVE_STEP = 1e-3  # numerics: of a logarithm, or of a parameter's own size
# likewise, where a joint that sticks a little longer makes a kink: the least change that matters
ACROSS_KINKS = MATERIAL
# numerics: tried each round, relative to the current; derivatives at the first
DAMPINGS = (0.2, 5.0)
TOLERANCE = 1e-3  # numerics: of the loss, which is 0.05 % of the error
LARGEST_LOG_STEP = 1.5  # numerics: a factor of 4.5: beyond, derivatives tell nothing
SMALL_DAMPING = 1.0  # numerics: below, a step is nearly that of Gauss and Newton
NEAR_ITS_END = 1e-3  # numerics: damping of a fit that begins there
LEAST_DAMPING = 1e-9  # numerics: keeps the normal equations solvable
# numerics: of the strongest one's sum of squares: damped as if an element moved as much
WEAK = 1e-6


@dataclass
class LeastSquares(Optimiser):
    """Minimises |q_sim − q|² over u (Levenberg, 1944; Marquardt, 1963).

    Attributes:
        layout: what u means.
        size: (n,) magnitude of each element, for finite differences.
        diagonal: assume that a joint's parameters move that joint alone, which makes one column
            serve all joints; those of a coupled effect excepted.
        free: (n,) bool, which elements are fitted.
        tolerance: relative decrease of the loss that counts as none.
        given: columns (nsample,) of the Jacobian, by slot key, that are not computed anew.
        secant: correct these by what each trial step shows (Broyden, A class of methods for
            solving nonlinear simultaneous equations, 1965).
        noise: rad, of a sample: what the rows of the layout's prior are weighed by, see `Layout`.
        last: iteration after which nobody needs derivatives, if there is one.
        gain: relative decrease of the loss in the last round.
        jacobian: (nsample, n) at u; residual: (nsample,) at u.
    """

    layout: Layout
    u: np.ndarray
    size: np.ndarray
    diagonal: bool = False
    free: np.ndarray | None = None
    damping: float = 1e-2  # numerics: at first
    tolerance: float = TOLERANCE
    given: dict[tuple, np.ndarray] = field(default_factory=dict)
    secant: bool = False
    noise: float = 0.0
    last: int | None = None
    loss: float = np.inf
    residual: np.ndarray | None = None
    jacobian: np.ndarray | None = None
    iterations: int = 0
    gain: float = 1.0
    done: bool = False
    _trial: np.ndarray | None = field(default=None, repr=False)
    _dampings: tuple = ()
    _products: tuple | None = field(default=None, repr=False)

    def __post_init__(self) -> None:
        fixed = self.layout.rough | (self.layout.lower >= self.layout.upper)
        self.free = ~fixed if self.free is None else self.free & ~fixed
        self.prior = self.noise * self.layout.prior

    @property
    def starting(self) -> bool:
        """Whether there are no derivatives yet."""
        return self.jacobian is None

    def points(self) -> np.ndarray:
        if self.jacobian is None:
            self._trial = self.u[None]
            return np.concatenate([self._trial, self._differences(self.u)[0]])
        self._dampings = tuple(self.damping * factor for factor in DAMPINGS)
        self._trial = np.array([self._step(damping) for damping in self._dampings])
        if self._ending:
            return self._trial
        centre = self._trial[0]
        return np.concatenate([self._trial, self._differences(centre)[0]])

    @property
    def _ending(self) -> bool:
        """Whether this round only looks for a better place."""
        return self.last is not None and self.iterations + 1 >= self.last

    def receive(self, residuals: np.ndarray, joints: np.ndarray) -> None:
        ntrial = len(self._trial)
        losses = np.mean(residuals[:ntrial] ** 2, axis=1)
        losses += np.sum((self._trial @ self.prior.T) ** 2, axis=1) / residuals.shape[1]
        losses = np.where(np.isfinite(losses), losses, np.inf)
        if self.jacobian is None:
            self.loss, self.residual = losses[0], residuals[0]
            self._take_jacobian(self.u, residuals[0], residuals[1:], joints)
            self.done = not np.isfinite(self.loss) or not self.free.any()
            return
        ending = self._ending
        self.iterations += 1
        best, centre = int(np.argmin(losses)), 0
        if self.secant and np.isfinite(losses[best]):
            self._correct(self._trial[best] - self.u, residuals[best] - self.residual)
        if losses[best] >= self.loss:
            # numerics: far beyond what was tried, or with other derivatives
            factor = 5.0 if self.secant else 30.0
            self.damping, self.gain = factor * self.damping, 0.0
            self.done = self.damping > 1e6  # numerics: no step is left
            return
        self.gain = 1 - losses[best] / self.loss
        self.u, self.loss, self.residual = self._trial[best], losses[best], residuals[best]
        self.damping = max(self._dampings[best], 1e-7)
        if ending:
            self.done = True
            return
        # around a neighbouring trial the derivatives serve as well
        around = centre if np.isfinite(losses[centre]) else best
        if around == centre:
            self._take_jacobian(self._trial[centre], residuals[centre], residuals[ntrial:], joints)
        # a heavily damped step that gains little is no minimum
        settled = self.gain < self.tolerance and self.damping < SMALL_DAMPING
        self.done = settled or abs(self.promise()) < self.tolerance

    def again(
        self, layout: Layout | None = None, keep: Sequence[int] | None = None
    ) -> "LeastSquares":
        """A fit from where this one ended, to other samples, or with some elements kept only."""
        index = slice(None) if keep is None else keep
        begun = LeastSquares(layout or self.layout, self.u[index], self.size[index], self.diagonal)
        begun.damping = NEAR_ITS_END
        return begun

    def columns(self) -> dict[tuple, np.ndarray]:
        """Columns of the Jacobian by slot key."""
        return {slot.key: self.jacobian[:, i] for i, slot in enumerate(self.layout.slots)}

    def promise(self) -> float:
        """Relative decrease of the loss that the linear model still expects of a full step.

        Negative where bounds cut the step short.
        """
        change = self._step(0.0) - self.u
        expected = self.residual + self.jacobian @ change
        square = np.sum(expected**2) + np.sum((self.prior @ (self.u + change)) ** 2)
        return float(1 - square / len(expected) / max(self.loss, np.finfo(float).tiny))

    def promised(self) -> float:
        """The loss that the linear model expects of a full step, at most that at u."""
        return self.loss * (1 - max(self.promise(), 0.0))

    def _correct(self, change: np.ndarray, difference: np.ndarray) -> None:
        """Let the given derivatives say what a step (n,) did to the residual (nsample,)."""
        along = change / np.maximum(np.abs(self.u), self.size) ** 2
        length = change @ along
        if length > 0:
            self.jacobian = self.jacobian + np.outer(
                (difference - self.jacobian @ change) / length, along
            )
            columns = self.columns()
            self.given = {key: columns[key] for key in self.given}

    def _columns(self) -> list[np.ndarray]:
        """Index sets of elements that are moved together."""
        slots = self.layout.slots
        free = [i for i in np.flatnonzero(self.free) if slots[i].key not in self.given]
        if not self.diagonal:
            return [np.array([i]) for i in free]
        groups: dict[tuple, list[int]] = {}
        for i in free:
            slot = self.layout.slots[i]
            key = (slot.term.effect.name, slot.parameter.name)
            groups.setdefault(key if self._alone(slot) else slot.key, []).append(i)
        return [np.array(group) for group in groups.values()]

    def _alone(self, slot: Slot) -> bool:
        """Whether it is taken to move its own joint alone."""
        return self.diagonal and slot.joint is not None and not slot.term.effect.coupled

    def _differences(self, u: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        layout = self.layout
        relative = np.where(layout.kinked, ACROSS_KINKS, RELATIVE_STEP)
        step = np.where(layout.log, 10 * relative, relative * np.maximum(np.abs(u), self.size))
        step = np.where(u + step > layout.upper, -step, step)
        columns = self._columns()
        points = np.repeat(u[None], len(columns), axis=0)
        for row, members in enumerate(columns):
            points[row, members] += step[members]
        return points, step

    def _take_jacobian(self, u, residual, moved, joints) -> None:
        _, step = self._differences(u)
        jacobian = np.zeros((len(residual), len(u)))
        for difference, members in zip(moved - residual, self._columns(), strict=True):
            # where a step runs away, nothing is known of it
            difference = np.where(np.isfinite(difference), difference, 0.0)
            for i in members:
                slot = self.layout.slots[i]
                if self._alone(slot):
                    jacobian[:, i] = np.where(joints == slot.joint, difference, 0.0) / step[i]
                else:
                    jacobian[:, i] = difference / step[i]
        for i, slot in enumerate(self.layout.slots):
            if slot.key in self.given and self.free[i]:
                jacobian[:, i] = self.given[slot.key]
        self.jacobian = jacobian

    def _normal(self) -> np.ndarray:
        """(n, n) of the normal equations, once for each Jacobian."""
        if self._products is None or self._products[0] is not self.jacobian:
            products = self.jacobian.T @ self.jacobian + self.prior.T @ self.prior
            self._products = self.jacobian, products
        return self._products[1]

    def _step(self, damping: float) -> np.ndarray:
        lower, upper = self.layout.lower, self.layout.upper
        gradient = self.jacobian.T @ self.residual + self.prior.T @ (self.prior @ self.u)
        outward = ((self.u <= lower) & (gradient > 0)) | ((self.u >= upper) & (gradient < 0))
        moving = np.flatnonzero(self.free & ~outward)
        if not len(moving):
            return self.u.copy()
        normal = self._normal()[np.ix_(moving, moving)]
        log, own = self.layout.log[moving], np.maximum(np.abs(self.u), self.size)[moving]
        unit = np.where(log, 1.0, own)
        moved = np.diag(normal) * unit**2
        scale = np.maximum(moved, max(WEAK * moved.max(), np.finfo(float).tiny)) / unit**2
        damped = normal + max(damping, LEAST_DAMPING) * np.diag(scale)
        change = -np.linalg.solve(damped, gradient[moving])
        limit = np.where(log, LARGEST_LOG_STEP, 20 * own)  # numerics: likewise
        change = np.clip(change, -limit, limit)
        new = self.u.copy()
        new[moving] += change
        return np.clip(new, lower, upper)
