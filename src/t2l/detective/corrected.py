"""Sets fitted in full simulation by few runs of it: the model along the motion, corrected.

    r(u) ≈ a(u) + g + D (u − u_k),   g = r(u_k) − a(u_k)

a is what the linear model of the loop leaves, which costs nothing, r what the simulation leaves.
What makes the right side small is simulated next. D makes it right too where the simulation was
before (Broyden, A class of methods for solving nonlinear simultaneous equations, 1965). Where that
ends, derivatives by simulation tell whether it is a minimum of the simulation. If it is not, the
simulation alone leads on.

Source: Alexandrov and Lewis, An overview of first-order model management for engineering
optimization, 2001; Bandler et al., Space mapping: the state of the art, 2004.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from t2l.detective.along_motion import AlongMotion
from t2l.detective.fitted_set import FittedSet, Start, sizes
from t2l.detective.left_out import fitted
from t2l.identify.fitting import PositionError
from t2l.identify.least_squares import TOLERANCE, LeastSquares
from t2l.identify.levels import AT_THE_FLOOR, PROMISING
from t2l.identify.optimiser import Objective, minimise
from t2l.identify.simulation import swinging

LED = 3  # numerics: iterations along the motion between two simulations
SHORTER = 0.3  # numerics: of a step that made the error larger
SHORTEST = 0.02  # numerics: of the step that the model asks for, below which none is left
SETTLING = 5  # numerics: iterations by simulation alone
LOOKED_AT = 2  # numerics: sets of fewest numbers, of which one must promise more
WORTH_IT = 0.1  # numerics: of the loss, which is 5 % of the error


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
        given: `beyond` of its start.
    """

    def __init__(self, start: Start, noise_rad: float):
        self.layout, self.u, self.trial = start.layout, start.u, start.u
        self.size, self.columns = sizes(start), dict(start.columns)
        self.prior = noise_rad * start.layout.prior
        self.loss, self.gain, self.iterations, self.done = np.inf, 1.0, 0, False
        self.given, self._reach = start.beyond, 1.0

    def at(self, points: np.ndarray) -> np.ndarray:
        """(m, nsample) beyond the model along the motion, at points (m, n)."""
        return self._gap + (points - self.u) @ self._slope.T

    def settle(self, real: LeastSquares, led: LeastSquares) -> None:
        """Take a fit by simulation, and at its end the derivatives along the motion."""
        self.u = self.trial = real.u
        self.loss, self.done = real.loss, True
        self._gap, self._slope = real.residual - led.residual, real.jacobian - led.jacobian
        slots = self.layout.slots
        self.columns = {slots[i].key: led.jacobian[:, i] for i in np.flatnonzero(led.free)}

    @property
    def beyond(self) -> dict[tuple, np.ndarray]:
        """See `Start`."""
        return {slot.key: self._slope[:, i] for i, slot in enumerate(self.layout.slots)}

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
            for i, slot in enumerate(self.layout.slots):
                self._slope[:, i] = self.given.get(slot.key, 0.0)
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
    settling: bool = False,
) -> list[FittedSet]:
    """Fit layouts that can be led from their starts; those that run away are left out.

    Args:
        simulated: the objective.
        iterations: simulations of each after that of its start.
        give_up: called before each round with all of them, to end some.
        settling: whether those near the best go on by simulation alone, if that leads further.
    """
    every = [Correction(start, along.noise_rad) for start in starts]
    _simulate(every, simulated, along)
    for _ in range(iterations):
        give_up([one for one in every if np.isfinite(one.loss)])
        active = [one for one in every if not one.done]
        _move(active, along)
        _simulate([one for one in active if not one.done], simulated, along)
    if settling:
        _settle(_promising(every, along.noise_rad), simulated, along)
    kept = [one for one in every if np.isfinite(one.loss)]
    fits = [LeastSquares(one.layout, one.u, one.size, noise=along.noise_rad) for one in kept]
    objective = _corrected(fits, kept, along)
    minimise(fits, objective, 0)
    beyond = {id(one.u): one.beyond for one in kept}
    return [replace(f, beyond=beyond[id(f.u)]) for f in fitted(fits, objective, folds)]


def _simulate(
    corrections: Sequence[Correction], simulated: PositionError, along: AlongMotion
) -> None:
    """Ask for each at its trial."""
    if corrections:
        asked = [(one, one.trial[None]) for one in corrections]
        both = zip(simulated.residuals(asked), along.residuals(asked), strict=True)
        for one, (real, led) in zip(corrections, both, strict=True):
            one.receive(real[0], led[0])


def _promising(every: Sequence[Correction], noise_rad: float) -> list[Correction]:
    """Those near the best that leave more than noise, if a simulation of them is quick.

    What swings freely has phases that each simulation looks for anew.
    """
    least = min((one.loss for one in every), default=0.0)
    most = PROMISING * max(least**0.5, noise_rad)
    return [
        one for one in every
        if AT_THE_FLOOR * noise_rad < one.loss**0.5 <= most and not swinging(one.layout.terms)
    ]  # fmt: skip


def _settle(
    corrections: Sequence[Correction], simulated: PositionError, along: AlongMotion
) -> None:
    """Fit those on by simulation alone, if its derivatives promise more for one of few numbers.

    Where the model along the motion is off by much, it ends beside the minimum. Of several those go
    on that promise more than any of fewer numbers.
    """
    noise = along.noise_rad
    fits = [LeastSquares(one.layout, one.u, one.size, noise=noise) for one in corrections]
    pairs = sorted(zip(corrections, fits, strict=True), key=lambda pair: pair[1].free.sum())
    least, chosen = np.inf, []
    for tried, (one, fit) in enumerate(pairs, start=1):
        _derive(fit, simulated, along)
        if not chosen and fit.promise() < WORTH_IT:
            if tried == LOOKED_AT:
                return
            continue
        if fit.promised() < (1 - WORTH_IT) * least:
            least = fit.promised()
            chosen.append((one, fit))
        if least <= (AT_THE_FLOOR * noise) ** 2:
            break
    minimise([fit for _, fit in chosen], simulated, SETTLING)
    led = [LeastSquares(fit.layout, fit.u, fit.size, noise=noise) for _, fit in chosen]
    minimise(led, along, 0)
    for (one, fit), at in zip(chosen, led, strict=True):
        one.settle(fit, at)


def _derive(fit: LeastSquares, simulated: PositionError, along: AlongMotion) -> None:
    """Give a fit the derivatives of the simulation.

    What a joint's own numbers do to other joints is taken along the motion, so that the numbers of
    all joints are moved together.
    """
    led, own = (
        LeastSquares(fit.layout, fit.u, fit.size, diagonal, noise=fit.noise)
        for diagonal in (False, True)
    )
    minimise([led, own], along, 0)
    fit.diagonal = True
    minimise([fit], simulated, 0)
    fit.jacobian = fit.jacobian + led.jacobian - own.jacobian
    fit.given, fit.secant = fit.columns(), True


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
