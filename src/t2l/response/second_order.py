"""A joint under position control as a second-order system, fitted to its commands and motion.

    q̈ = ω² (g c(t − d) + b − q) − 2 ζ ω q̇

c is the command, held from row to row. Of a loop with stiffness Kp and damping Kd about an inertia
M, ω² = Kp/M and 2 ζ ω = Kd/M. Delay d, gain g and bias b stand for what else a machine does; d and
g are part of the fit only where the motion asks for them. Each motion has a start of its own.

What is linear in the motion (b, g c, starts) is solved for inside the
search over (ln ω, ln ζ, d): variable projection, Golub and Pereyra, 1973.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares

from t2l.identify.block_bootstrap import blocks
from t2l.response.track import Track, respond

Z95 = 1.96
CLEAR = 3.0  # standard errors: a data set has many joints, and one in 370 of no delay passes
# rad/s and 1: from far slower to far faster than a joint moves; they only bound the search
FREQUENCIES, DAMPINGS = (0.3, 3000.0), (0.01, 100.0)
NEAR = 1.05  # times a bound
LONGEST_DELAY_S = 0.5
STILL = 1e-6  # of the commands' spread: a joint that moves less does not move
# where searches begin: an octave and a half apart, a basin of the error is wider
STARTS = [(w, z) for w in 2.0 ** np.arange(0, 9, 1.5) for z in (0.15, 0.7, 3.0)]
EXTRAS = ("delay", "gain")
TRIED = 2  # of the starts, the best


@dataclass(frozen=True)
class SecondOrder:
    """What fits the motions.

    Attributes:
        omega: ω, rad/s; zeta: ζ.
        covariance: (2, 2) of (ln ω, ln ζ); infinite where the search ended at its bounds, as the
            motions do not tell.
        delay_s, gain: with 95 % intervals; 0 and 1 with no interval where they are not fitted.
        rmse: of position, in its unit; explained: share of the variance of the motion, NaN of a
            joint that does not move, of which nothing else is told either.
        predicted: (m,) position at the measured instants of each track.
    """

    omega: float
    zeta: float
    covariance: np.ndarray
    delay_s: float
    delay_interval: tuple[float, float] | None
    gain: float
    gain_interval: tuple[float, float] | None
    rmse: float
    explained: float
    predicted: tuple[np.ndarray, ...]

    @property
    def moves(self) -> bool:
        """Whether the joint does."""
        return not np.isnan(self.explained)

    def interval(self, i: int) -> tuple[float, float]:
        """95 % interval of ω (0) or ζ (1)."""
        half = Z95 * np.sqrt(self.covariance[i, i])
        value = (self.omega, self.zeta)[i]
        # a wide one is none
        with np.errstate(over="ignore"):
            return float(value * np.exp(-half)), float(value * np.exp(half))


def fit(tracks: Sequence[Track]) -> SecondOrder:
    """ω and ζ with which the system moves as the tracks do, all of one joint under one loop.

    Delay and gain join the fit, the one that lowers the error most first, while they are
    `CLEAR` standard errors from 0 and 1 and Schwarz's criterion (1978) asks for them: a forward
    selection. Where damping is high, a delay taken in by chance would leave ω open.
    """
    best = _search(tracks, delay=False, gain=False)
    while best.moves:
        tried = []
        for extra in ("delay", "gain"):
            if extra not in best.extras:
                wider = _search(
                    tracks, **{e: e == extra or e in best.extras for e in EXTRAS}, start=best.x
                )
                gained = len(best.q) * np.log(best.cost / max(wider.cost, 1e-300))
                if wider.distance(extra) > CLEAR and gained > np.log(len(best.q)):
                    tried.append(wider)
        if not tried:
            break
        best = min(tried, key=lambda search: search.cost)
    return best.result(tracks)


class _Search:
    """One least-squares problem over (ln ω, ln ζ[, d]) and its solution."""

    def __init__(self, tracks, delay: bool, gain: bool):
        self.tracks, self.delay, self.gain = tracks, delay, gain
        self.extras = [e for e in EXTRAS if {"delay": delay, "gain": gain}[e]]
        self.q = np.concatenate([track.q for track in tracks])
        seconds = [track.at * track.period_s for track in tracks]
        which = np.repeat(np.arange(len(tracks)), [len(s) for s in seconds])
        self.block = blocks(which, np.concatenate(seconds))
        # so that commands far from zero cost no digits
        self.centre = float(np.mean(self.q))
        own = self.q - (np.bincount(which, self.q) / np.bincount(which))[which]
        asked = np.concatenate([track.command - track.command.mean() for track in tracks])
        self.variance = float(np.mean(own**2))
        self.moves = self.variance > STILL**2 * float(np.mean(asked**2))

    def columns(self, x) -> tuple[np.ndarray, np.ndarray]:
        """Response to the commands (m,), and columns (m, k) of what is linear: bias, starts."""
        omega, zeta = np.exp(x[0]), np.exp(x[1])
        delay = x[2] if self.delay else 0.0
        m, at = len(self.q), 0
        response, linear = np.empty(m), np.zeros((m, 1 + 2 * len(self.tracks)))
        linear[:, 0] = 1.0
        for i, track in enumerate(self.tracks):
            rows = slice(at, at + len(track.q))
            forced, position, velocity = respond(track, omega, zeta, delay, self.centre)
            response[rows] = forced + self.centre
            linear[rows, 1 + 2 * i], linear[rows, 2 + 2 * i] = position, velocity
            at += len(track.q)
        return response, linear

    def solve(self, x) -> tuple[np.ndarray, np.ndarray]:
        """Residual (m,) and the linear parameters, the gain last."""
        response, linear = self.columns(x)
        if self.gain:
            parts, target = np.column_stack([linear, response - self.centre]), self.q - self.centre
        else:
            parts, target = linear, self.q - response
        weights = np.linalg.lstsq(parts, target, rcond=1e-10)[0]
        return parts @ weights - target, weights

    def residual(self, x) -> np.ndarray:
        return self.solve(x)[0]

    def run(self, start) -> "_Search":
        low = [np.log(FREQUENCIES[0]), np.log(DAMPINGS[0]), *([0.0] if self.delay else [])]
        high = [np.log(FREQUENCIES[1]), np.log(DAMPINGS[1])]
        high += [LONGEST_DELAY_S] if self.delay else []
        inside = np.clip(start, np.add(low, 1e-9), np.subtract(high, 1e-9))
        # a delay of 10 ms is as much as a factor of e
        scale = [1.0, 1.0, *([0.01] if self.delay else [])]
        found = least_squares(self.residual, inside, bounds=(low, high), x_scale=scale, xtol=1e-10)
        self.x, self.cost = found.x, float(np.mean(found.fun**2))
        if self.moves:
            self._take_covariance()
        return self

    def _take_covariance(self) -> None:
        """Sandwich with blocks of time as clusters (White, 1984, section VI.3), of x then gain."""
        residual, weights = self.solve(self.x)
        response, linear = self.columns(self.x)
        n = len(self.x)
        jacobian = np.empty((len(residual), n))
        for i in range(n):
            step = np.zeros(n)
            step[i] = 1e-5 if i < 2 else 1e-6
            ahead = self._full(self.x + step, weights)
            # one-sided at a delay of zero
            behind = self._full(self.x - step if self.x[i] > step[i] or i < 2 else self.x, weights)
            width = 2 if self.x[i] > step[i] or i < 2 else 1
            jacobian[:, i] = (ahead - behind) / (width * step[i])
        if self.gain:
            jacobian = np.column_stack([jacobian, response - self.centre])
        # the linear parameters are solved for: only what they cannot imitate counts
        basis = np.linalg.qr(linear)[0]
        jacobian -= basis @ (basis.T @ jacobian)
        norm = np.sqrt((jacobian**2).sum(axis=0)) + 1e-300
        scaled = jacobian / norm
        inverse = np.linalg.pinv(scaled.T @ scaled, rcond=1e-12)
        sums = np.zeros((self.block.max() + 1, scaled.shape[1]))
        np.add.at(sums, self.block, scaled * residual[:, None])
        robust = inverse @ (sums.T @ sums) @ inverse * len(sums) / max(len(sums) - 1, 1)
        plain = inverse * np.mean(residual**2) * len(residual) / max(len(residual) - 5, 1)
        # few blocks underestimate: never less than white noise would leave
        wider = np.maximum(1.0, np.sqrt(np.diag(plain) / np.maximum(np.diag(robust), 1e-300)))
        self.covariance = robust * np.outer(wider, wider) / np.outer(norm, norm)

    def _full(self, x, weights) -> np.ndarray:
        response, linear = self.columns(x)
        if self.gain:
            return np.column_stack([linear, response - self.centre]) @ weights
        return linear @ weights + response

    def error(self, extra: str) -> float:
        i = {"delay": 2, "gain": len(self.covariance) - 1}[extra]
        return float(np.sqrt(self.covariance[i, i]))

    def value(self, extra: str) -> float:
        return float(self.x[2]) if extra == "delay" else float(self.solve(self.x)[1][-1])

    def distance(self, extra: str) -> float:
        """Standard errors between an extra and its absence."""
        return abs(self.value(extra) - (extra == "gain")) / max(self.error(extra), 1e-12)

    def _with_interval(self, extra: str, absent: float):
        if extra not in self.extras:
            return absent, None
        value, half = self.value(extra), Z95 * self.error(extra)
        return value, (value - half, value + half)

    def _on_bound(self) -> bool:
        at = np.exp(self.x[:2])
        low, high = np.transpose([FREQUENCIES, DAMPINGS])
        return bool((at < NEAR * low).any() or (at > high / NEAR).any())

    def result(self, tracks) -> SecondOrder:
        residual = self.residual(self.x)
        delay, delay_interval = self._with_interval("delay", 0.0)
        gain, gain_interval = self._with_interval("gain", 1.0)
        ends = np.cumsum([len(track.q) for track in tracks])[:-1]
        told = self.moves and not self._on_bound()
        return SecondOrder(
            omega=float(np.exp(self.x[0])),
            zeta=float(np.exp(self.x[1])),
            covariance=self.covariance[:2, :2] if told else np.full((2, 2), np.inf),
            delay_s=delay,
            delay_interval=delay_interval,
            gain=gain,
            gain_interval=gain_interval,
            rmse=float(np.sqrt(self.cost)),
            explained=1 - self.cost / self.variance if self.moves else float("nan"),
            predicted=tuple(np.split(self.q + residual, ends)),
        )


def _search(tracks, delay: bool, gain: bool, start=None) -> _Search:
    if start is not None:
        # a delay that is not there yet begins at a row's period
        start = [*start, *([tracks[0].period_s] if delay and len(start) < 3 else [])]
        return _Search(tracks, delay, gain).run(start)
    probe = _Search(tracks, delay, gain)
    costs = [float(np.mean(probe.residual(np.log(point)) ** 2)) for point in STARTS]
    chosen = [STARTS[i] for i in np.argsort(costs)[:TRIED]]
    found = [_Search(tracks, delay, gain).run(np.log(point)) for point in chosen]
    return min(found, key=lambda search: search.cost)
