"""Sets fitted in full simulation by few runs of it: the model along the motion, corrected.

    r(u) ≈ a(u) + g + D (u − u_k),   g = r(u_k) − a(u_k)

a is what the linear model of the loop leaves, which costs nothing, r what the simulation leaves.
What makes the right side small is simulated next. D makes it right too where the simulation was
before (Broyden, A class of methods for solving nonlinear simultaneous equations, 1965).

Source: Alexandrov and Lewis, An overview of first-order model management for engineering
optimization, 2001; Bandler et al., Space mapping: the state of the art, 2004.
"""

from collections.abc import Callable, Sequence

import numpy as np

from t2l.detective.along_motion import AlongMotion
from t2l.detective.fitted_set import FittedSet, Start, sizes
from t2l.detective.left_out import fitted
from t2l.identify.fitting import PositionError
from t2l.identify.least_squares import TOLERANCE, LeastSquares
from t2l.identify.optimiser import Objective, minimise

LED = 3  # numerics: iterations along the motion between two simulations
SHORTER = 0.3  # numerics: of a step that made the error larger
SHORTEST = 0.02  # numerics: of the step that the model asks for, below which none is left


class Corrected(Objective):
    """Positions along the motion, for each fit with its own correction."""

    def __init__(self, along: AlongMotion, corrections: dict[int, "Correction"]):
        self.along, self.corrections, self.joints = along, corrections, along.joints
        self.recordings = along.recordings

    def residuals(self, asked):
        led = self.along.residuals(asked)
        return [
            residual + self.corrections[id(fit)].at(points)
            for residual, (fit, points) in zip(led, asked, strict=True)
        ]


class Correction:
    """What the simulation of a set says beyond the model along the motion.

    Attributes:
        layout, u: where the simulation leaves least so far.
        trial: (n,) where it is asked next.
        loss: at u, mean squared residual, what the priors of the layout say included.
        gain: relative decrease of the loss by the last trial.
        columns: derivatives along the motion, see `Start`.
        done: whether more trials would gain nothing.
    """

    def __init__(self, start: Start, noise_rad: float):
        self.layout, self.u, self.trial = start.layout, start.u, start.u
        self.size, self.columns = sizes(start), dict(start.columns)
        self.prior = noise_rad * start.layout.prior
        self.loss, self.gain, self.iterations, self.done = np.inf, 1.0, 0, False
        self._reach = 1.0

    def at(self, points: np.ndarray) -> np.ndarray:
        """(m, nsample) beyond the model along the motion, at points (m, n)."""
        return self._gap + (points - self.u) @ self._slope.T

    @property
    def derivatives(self) -> dict[tuple, np.ndarray]:
        """Of the corrected model, as far as they are known, see `Start`."""
        keys = (slot.key for slot in self.layout.slots)
        known = ((i, key) for i, key in enumerate(keys) if key in self.columns)
        return {key: self.columns[key] + self._slope[:, i] for i, key in known}

    def receive(self, simulated: np.ndarray, led: np.ndarray) -> None:
        """Take the residuals (nsample,) at the trial, by simulation and along the motion."""
        gap, moved, first = simulated - led, self.trial - self.u, not np.isfinite(self.loss)
        loss = np.mean(simulated**2) + np.sum((self.prior @ self.trial) ** 2) / len(simulated)
        if first:
            self._slope = np.zeros((len(simulated), len(self.u)))
            self.done = not np.isfinite(loss)
        elif np.isfinite(loss):
            along = moved / np.maximum(np.abs(self.u), self.size) ** 2
            missed = gap - self.at(self.trial[None])[0]
            self._slope += np.outer(missed / max(moved @ along, np.finfo(float).tiny), along)
        if np.isfinite(loss) and (first or loss < self.loss):
            self.gain = 1.0 if first else 1 - loss / self.loss
            self.u, self.loss, self._gap, self._reach = self.trial, loss, gap, 1.0
            self.done = self.gain < TOLERANCE
        else:
            self.gain, self._reach = 0.0, SHORTER * self._reach
            self.done |= self._reach < SHORTEST
        self.iterations += not first

    def move(self, fit: LeastSquares) -> None:
        """Try next where the corrected model leaves least."""
        self.trial = self.u + self._reach * (fit.u - self.u)
        slots, led = self.layout.slots, fit.jacobian - self._slope
        self.columns = {slots[i].key: led[:, i] for i in np.flatnonzero(fit.free)}
        self.done |= not fit.loss < (1 - TOLERANCE) * self.loss


def fit_corrected(
    starts: Sequence[Start],
    along: AlongMotion,
    simulated: PositionError,
    folds: np.ndarray,
    iterations: int,
    give_up: Callable[[Sequence[Correction]], None] = lambda corrections: None,
) -> list[FittedSet]:
    """Fit layouts that can be led from their starts; those that run away are left out.

    Args:
        simulated: the objective.
        iterations: simulations of each after that of its start.
        give_up: called after each round with all of them, to end some.
    """
    every = [Correction(start, along.noise_rad) for start in starts]
    for iteration in range(iterations + 1):
        active = [one for one in every if not one.done]
        if iteration:
            _move(active, along)
            active = [one for one in active if not one.done]
        if not active:
            break
        asked = [(one, one.trial[None]) for one in active]
        both = zip(simulated.residuals(asked), along.residuals(asked), strict=True)
        for one, (real, led) in zip(active, both, strict=True):
            one.receive(real[0], led[0])
        give_up([one for one in every if np.isfinite(one.loss)])
    kept = [one for one in every if np.isfinite(one.loss)]
    fits = [LeastSquares(one.layout, one.u, one.size, noise=along.noise_rad) for one in kept]
    objective = _corrected(fits, kept, along)
    minimise(fits, objective, 0)
    return fitted(fits, objective, folds)


def _move(corrections: Sequence[Correction], along: AlongMotion) -> None:
    """Let each go where its corrected model leaves least."""
    fits = [
        LeastSquares(
            one.layout, one.u.copy(), one.size, noise=along.noise_rad, given=one.derivatives,
            secant=bool(one.columns),
        )
        for one in corrections
    ]  # fmt: skip
    minimise(fits, _corrected(fits, corrections, along), LED)
    for one, fit in zip(corrections, fits, strict=True):
        one.move(fit)


def _corrected(fits, corrections: Sequence[Correction], along: AlongMotion) -> Corrected:
    return Corrected(along, {id(f): one for f, one in zip(fits, corrections, strict=True)})
