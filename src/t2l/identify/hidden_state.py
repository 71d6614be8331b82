"""How a log begins: with what velocity, with what torque held, and how where no encoder looks.

What no encoder sees is the far side of a spring or of play. From rest it hangs where its load
leaves it. In motion its angle and velocity against the motor are estimated from the first moments
of each recording, for every variant of the model anew, as the initial state of a simulation error
is (Ljung, System Identification, 1999, section 7.5): the first samples depend on them linearly,
nearly, so that few Gauss-Newton steps do. Play is not smooth: the side on which the teeth touch is
tried first. Nor is what can hold so much and no more.

The velocity of what the encoder does see is estimated likewise, in one step from the slope of the
first positions, which is the prior with what it may be off by. No polynomial tells it well enough:
torque jumps at every command, so that a long one is wrong, and of a short one the encoder's noise
leaves per cents.

What remembers a torque, bristles or an integral, holds one that nobody knows where a log begins in
motion, and an integral at rest too, where friction balances it. It is estimated likewise, as a
share of what it can hold.

What swings freely has a phase that nobody knows in any recording. The first half of a recording
tells it, a half second too little of a slow one; the other half is foretold. The response to a sine
is known from three phases: it is affine in sine and cosine, nearly, so that the best angle of a
joint is known too.

No step is taken that leaves more than before: a joint that dry friction holds hardly answers to a
small velocity, and leaps with a large one.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from t2l.identify.block_bootstrap import BLOCK_S
from t2l.identify.levels import HALF
from t2l.sim.loop import HELD, PHASE
from t2l.sim.schedule import Schedule

WINDOW_S = BLOCK_S  # of a recording; what a joint no longer remembers says nothing
# tuned: likewise if only velocities are unknown: an encoder of 0.1 mrad at 200 Hz tells them to 2
# mrad/s in it, to 3 in half of it; the longer, the more a lacking effect is taken for a velocity
VELOCITY_S = 0.1
# of the far side's angle and velocity, of the velocity that the encoder's own side is off by, of
# the torque held and of a phase
STEPS = (1e-4, 1e-3, 1e-3, 0.03, 0.03)  # numerics: of differences: rad, rad/s, rad/s, share, rad
EXPECTED = (0.05, 1.0, 1.0, 1.0, np.pi)  # bound: likewise; more is taken for something else
UNKNOWN = len(STEPS)
FAR = (0, 1, 2)  # format: of these, what a joint with a far side has
VELOCITY = 2  # format: what every joint has
SIDES = (-1.0, -0.5, 0.5, 1.0)  # guess: of the play, from where the load leaves the teeth
SHARES = (-1.5, -0.75, 0.75, 1.5)  # guess: of what bristles can hold, from balance
# guess: likewise of what is clamped, where a step may change nothing
CLAMPED = (-1.75, -1.4, -1.05, -0.7, -0.35, 0.35, 0.7, 1.05, 1.4, 1.75)
THIRDS = 2 * np.pi / 3 * np.arange(3)  # numerics: phases that tell the response to all
ANGLES = 2 * np.pi / 360 * np.arange(360)  # numerics: phases that are compared
ITERATIONS = 2  # numerics: of Gauss and Newton: the response is nearly linear
SHORTER = 0.3  # numerics: of a step that left more than before
MOST = 2.0  # bound: of shares: from all one way to all the other

Unknowns = list[tuple[int, int]]  # a joint, and which of STEPS


@dataclass(frozen=True)
class Beginning:
    """The first moments of the recordings of a group.

    Attributes:
        schedule: theirs, with fewer `sample_ticks`.
        wanted: as of `t2l.identify.simulation.simulate`, of the samples of `measured` alone.
        measured: (k,) rad.
        noise_rad: of a measured position.
        memory_s: of this, what tells all but a phase.
        holds: (nrec,) bool, where a torque may be held beyond balance; None for all.
        doubt: (nrec, njoint) rad/s, what `Schedule.start_dq` may be off by; zero where it is sure.
    """

    schedule: Schedule
    wanted: tuple[np.ndarray, ...]
    measured: np.ndarray
    noise_rad: float
    doubt: np.ndarray
    memory_s: float = np.inf
    holds: np.ndarray | None = None

    @property
    def half_s(self) -> float:
        """Half of the longest recording."""
        return HALF * float(self.schedule.sample_ticks[-1]) * self.schedule.period_s

    @property
    def _may_hold(self) -> np.ndarray:
        return np.ones(len(self.doubt), bool) if self.holds is None else self.holds

    def within(self, window_s: float) -> "Beginning":
        """No more than so much of it."""
        last = int(np.ceil(window_s / self.schedule.period_s))
        ticks = self.schedule.sample_ticks[self.schedule.sample_ticks <= last]
        early = np.flatnonzero(self.wanted[1] + 1 < len(ticks))
        return replace(
            self,
            schedule=replace(self.schedule, sample_ticks=ticks),
            wanted=tuple(w[early] for w in self.wanted),
            measured=self.measured[early],
        )

    def of(self, recordings: np.ndarray) -> "Beginning":
        """Of some recordings, (k,) indices."""
        there = np.isin(self.wanted[0], recordings)
        record, *others = (w[there] for w in self.wanted)
        return replace(
            self,
            schedule=self.schedule.of(recordings),
            wanted=(np.searchsorted(recordings, record), *others),
            measured=self.measured[there],
            doubt=self.doubt[recordings],
            holds=None if self.holds is None else self.holds[recordings],
        )

    def estimate(
        self,
        predict: Callable[[np.ndarray], np.ndarray],
        joints: Sequence[int],
        play: np.ndarray,
        holding: Sequence[int] = (),
        guesses: Sequence[float] = SHARES,
        swinging: Sequence[int] = (),
    ) -> np.ndarray:
        """Starts as of `t2l.sim.loop.Loop.hidden_start`, (m, nrec, njoint, k).

        Args:
            predict: position (c m, k) of c copies of m variants, from their starts
                (c m, nrec, njoint, k).
            joints: indices of those that have a far side.
            play: (m, nrec, njoint) rad.
            holding: likewise of those that hold a torque; `guesses` of its share are tried first.
            swinging: likewise of those that swing freely.
        """
        m, nrec, njoint = play.shape

        def errors(starts: np.ndarray) -> np.ndarray:
            """(c, m, k) of starts (c, m, nrec, njoint, k)."""
            q = predict(starts.reshape(-1, nrec, njoint, UNKNOWN)).reshape(len(starts), m, -1)
            return np.nan_to_num(q - self.measured, nan=1e3)

        start = np.zeros((m, nrec, njoint, UNKNOWN))
        moving = self._unknowns(joints, holding, swinging)
        if swinging:
            start = self._turned(errors, start, swinging)
        if play.any():
            start = self._best_of(errors, start, 0, np.multiply.outer(SIDES, play))
        if holding:
            shares = np.zeros((len(guesses), m, nrec, njoint))
            shares[..., holding] = np.array(guesses)[:, None, None, None]
            shares *= self._may_hold[:, None]
            start = self._best_of(errors, start, HELD, shares)
        best, least, step = start, np.full((m, nrec), np.inf), np.zeros_like(start)
        # of velocities and phases alone one step is enough
        steps = ITERATIONS if joints or holding else 1
        for iteration in range(steps + 1):
            moved = start[None] if iteration == steps else _moved(start, moving)
            error = errors(moved)
            left = self._by_recording(error[0] ** 2)
            better = (left < least)[..., None, None]
            best, least = np.where(better, start, best), np.minimum(left, least)
            if iteration < steps:
                step = np.where(better, self._step(error, moving, njoint), SHORTER * step)
                start = best + step
                start[..., HELD] = np.clip(start[..., HELD], -MOST, MOST)
                # of the velocity of other joints one step is enough
                moving = [
                    some for some in moving if some[0][0] in joints or some[0][1] in (HELD, PHASE)
                ]
        return best

    def _unknowns(
        self, joints: Sequence[int], holding: Sequence[int], swinging: Sequence[int]
    ) -> list[Unknowns]:
        """What is moved at a time: one number of `joints` or a velocity that there is doubt about.

        Torques that are held are moved together, as they hardly move other joints, and phases.
        """
        others = [int(j) for j in np.flatnonzero(self.doubt.any(axis=0)) if j not in joints]
        alone = [(joint, kind) for joint in joints for kind in FAR]
        alone += [(joint, VELOCITY) for joint in others]
        held = [(joint, HELD) for joint in holding]
        phases = [(joint, PHASE) for joint in swinging]
        return [*([one] for one in alone), *(some for some in (held, phases) if some)]

    def _turned(self, errors: Callable, start: np.ndarray, swinging: Sequence[int]) -> np.ndarray:
        """Starts with the phase that leaves each joint the least."""
        starts = np.repeat(start[None], len(THIRDS), axis=0)
        starts[..., swinging, PHASE] = THIRDS[:, None, None, None]
        error, turned = errors(starts), start.copy()
        # error = rest + cosine cos φ + sine sin φ
        rest = error.mean(axis=0)
        cosine, sine = (2 / 3 * np.tensordot(f(THIRDS), error, 1) for f in (np.cos, np.sin))
        parts = np.stack([rest, cosine, sine])
        waves = np.stack([np.ones_like(ANGLES), np.cos(ANGLES), np.sin(ANGLES)])
        for j in swinging:
            own = parts * (self.wanted[3] == j)
            of = np.array([[self._by_recording(a * b) for a in parts] for b in own])
            left = np.einsum("ia,jimr,ja->amr", waves, of, waves)
            turned[..., j, PHASE] = ANGLES[np.argmin(left, axis=0)]
        return turned

    def _by_recording(self, values: np.ndarray) -> np.ndarray:
        """Sums (m, nrec) of values (m, k)."""
        of = self.wanted[0][:, None] == np.arange(len(self.schedule.kp))
        return values @ of

    def _best_of(
        self, errors: Callable, start: np.ndarray, kind: int, guesses: np.ndarray
    ) -> np.ndarray:
        """Of guesses (c, m, nrec, njoint) of a kind, or as it is: what leaves a joint the least."""
        starts = np.repeat(start[None], 1 + len(guesses), axis=0)
        starts[1:, ..., kind] = guesses
        square, chosen = errors(starts) ** 2, start.copy()
        for j in range(start.shape[2]):
            left = np.array([self._by_recording(s * (self.wanted[3] == j)) for s in square])
            best = np.argmin(left, axis=0)
            chosen[..., j, kind] = np.take_along_axis(starts[..., j, kind], best[None], axis=0)[0]
        return chosen

    def _step(self, error: np.ndarray, moving: list[Unknowns], njoint: int) -> np.ndarray:
        """Gauss and Newton's, with what is expected as the prior, (m, nrec, njoint, k).

        Args:
            error: (1 + len(moving), m, k) as it is, and with some unknowns a step further. What
                is moved together counts for its own joint only.
        """
        unknowns = [one for some in moving for one in some]
        at_joint, of_kind = np.array(unknowns).T
        moved = np.repeat(error[1:] - error[0], [len(some) for some in moving], axis=0)
        alone = np.array([len(some) == 1 for some in moving for _ in some])
        moved *= (alone[:, None] | (self.wanted[3] == at_joint[:, None]))[:, None]
        if PHASE in of_kind:
            after_s = self.schedule.sample_ticks[self.wanted[1]] * self.schedule.period_s
            moved *= ((after_s <= self.memory_s) | (of_kind[:, None] == PHASE))[:, None]
        slopes = np.moveaxis(moved / np.array(STEPS)[of_kind, None, None], 0, -1)
        nrec = len(self.schedule.kp)
        step = np.zeros((error.shape[1], nrec, njoint, UNKNOWN))
        for record in range(nrec):
            at = self.wanted[0] == record
            unit = self._expected(record, unknowns)
            scaled = slopes[:, at] * unit / self.noise_rad
            off = error[0][:, at, None] / self.noise_rad
            across = np.swapaxes(scaled, 1, 2)
            # the least step of many where simulations fell over: the prior is lost in rounding
            inverse = np.linalg.pinv(across @ scaled + np.eye(len(unit)), hermitian=True)
            step[:, record, at_joint, of_kind] = -(inverse @ (across @ off))[..., 0] * unit
        return step

    def _expected(self, record: int, unknowns: Unknowns) -> np.ndarray:
        """(n,), of the velocity of a joint without a far side no more than its doubt."""
        far = {joint for joint, kind in unknowns if kind == 0}
        return np.array(
            [
                self.doubt[record, j]
                if kind == VELOCITY and j not in far
                else EXPECTED[kind] * (kind != HELD or self._may_hold[record])
                for j, kind in unknowns
            ]
        )


def _moved(start: np.ndarray, moving: list[Unknowns]) -> np.ndarray:
    """`start` (m, nrec, njoint, k), then some of the unknowns a step further, and others."""
    moved = np.repeat(start[None], 1 + len(moving), axis=0)
    for i, unknowns in enumerate(moving):
        for joint, kind in unknowns:
            moved[1 + i, ..., joint, kind] += STEPS[kind]
    return moved
