"""How a log begins: with what velocity, and how where no encoder looks.

What no encoder sees is the far side of a spring or of play. From rest it hangs where its load
leaves it. In motion its angle and velocity against the motor are estimated from the first moments
of each recording, for every variant of the model anew, as the initial state of a simulation error
is (Ljung, System Identification, 1999, section 7.5): the first samples depend on them linearly,
nearly, so that few Gauss-Newton steps do. Play is not smooth: the side on which the teeth touch is
tried first.

The velocity of what the encoder does see is estimated likewise, in one step from the slope of the
first positions, which is the prior with what it may be off by. No polynomial tells it well enough:
torque jumps at every command, so that a long one is wrong, and of a short one the encoder's noise
leaves per cents.

No step is taken that leaves more than before: a joint that dry friction holds hardly answers to a
small velocity, and leaps with a large one.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from t2l.identify.block_bootstrap import BLOCK_S
from t2l.sim.schedule import Schedule

WINDOW_S = BLOCK_S  # of a recording; what a joint no longer remembers says nothing
# tuned: likewise if only velocities are unknown: an encoder of 0.1 mrad at 200 Hz tells them to 2
# mrad/s in it, to 3 in half of it; the longer, the more a lacking effect is taken for a velocity
VELOCITY_S = 0.1
# of the far side's angle and velocity, and of the velocity that the encoder's own side is off by
STEPS = (1e-4, 1e-3, 1e-3)  # numerics: rad, rad/s and rad/s, of finite differences
EXPECTED = (0.05, 1.0, 1.0)  # bound: likewise; more is taken for something else
UNKNOWN = len(STEPS)
VELOCITY = 2  # format: of these, what every joint has
SIDES = (-1.0, -0.5, 0.5, 1.0)  # guess: of the play, from where the load leaves the teeth
ITERATIONS = 2  # numerics: of Gauss and Newton: the response is nearly linear

Unknowns = list[tuple[int, int]]  # a joint, and which of STEPS


@dataclass(frozen=True)
class Beginning:
    """The first moments of the recordings of a group, of which some begin in motion.

    Then what no encoder sees may move in all: one that begins where a motion turns looks as if it
    were at rest.

    Attributes:
        schedule: theirs, with fewer `sample_ticks`.
        wanted: as of `t2l.identify.simulation.simulate`, of the samples of `measured` alone.
        measured: (k,) rad.
        noise_rad: of a measured position.
        doubt: (nrec, njoint) rad/s, what `Schedule.start_dq` may be off by; zero where it is sure.
    """

    schedule: Schedule
    wanted: tuple[np.ndarray, ...]
    measured: np.ndarray
    noise_rad: float
    doubt: np.ndarray

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
        )

    def estimate(
        self,
        predict: Callable[[np.ndarray], np.ndarray],
        joints: list[int],
        play: np.ndarray,
        rough: bool = False,
    ) -> np.ndarray:
        """Starts as of `t2l.sim.servo.ServoLoop.hidden_start`, (m, nrec, njoint, 3).

        Args:
            predict: position (c m, k) of c copies of m variants, from their starts
                (c m, nrec, njoint, 3).
            joints: indices of those that have a far side.
            play: (m, nrec, njoint) rad.
            rough: one step only, as if no joint's start moved another joint.
        """
        m, nrec, njoint = play.shape

        def errors(starts: np.ndarray) -> np.ndarray:
            """(c, m, k) of starts (c, m, nrec, njoint, 3)."""
            q = predict(starts.reshape(-1, nrec, njoint, UNKNOWN)).reshape(len(starts), m, -1)
            return np.nan_to_num(q - self.measured, nan=1e3)

        start = np.zeros((m, nrec, njoint, UNKNOWN))
        moving = self._unknowns(joints, rough)
        if play.any():
            start = self._side(errors, play)
        best, least = start, np.full((m, nrec), np.inf)
        steps = ITERATIONS if joints and not rough else 1
        for iteration in range(steps + 1):
            moved = start[None] if iteration == steps else _moved(start, moving)
            error = errors(moved)
            left = self._by_recording(error[0] ** 2)
            better = (left < least)[..., None, None]
            best, least = np.where(better, start, best), np.minimum(left, least)
            if iteration < steps:
                start = best + np.where(better, self._step(error, moving, njoint), 0.0)
                # of the other joints one step is enough
                moving = moving[: UNKNOWN * len(joints)]
        return best

    def _unknowns(self, joints: list[int], together: bool) -> list[Unknowns]:
        """All of `joints`, and the velocity of the others that there is doubt about.

        Each alone, or all of a kind `together`.
        """
        others = [int(j) for j in np.flatnonzero(self.doubt.any(axis=0)) if j not in joints]
        far = [(joint, kind) for joint in joints for kind in range(UNKNOWN)]
        every = far + [(joint, VELOCITY) for joint in others]
        if not together:
            return [[one] for one in every]
        of_kind = ([one for one in every if one[1] == kind] for kind in range(UNKNOWN))
        return [unknowns for unknowns in of_kind if unknowns]

    def _by_recording(self, values: np.ndarray) -> np.ndarray:
        """Sums (m, nrec) of values (m, k)."""
        of = self.wanted[0][:, None] == np.arange(len(self.schedule.kp))
        return values @ of

    def _side(self, errors: Callable, play: np.ndarray) -> np.ndarray:
        """Of where the teeth may be, for each joint what leaves it the least error."""
        angles = np.array([0.0, *SIDES])[:, None, None, None] * play
        starts = np.zeros((*angles.shape, UNKNOWN))
        starts[..., 0] = angles
        square, joint = errors(starts) ** 2, self.wanted[3]
        chosen = np.zeros_like(starts[0])
        for j in range(play.shape[2]):
            left = np.array([self._by_recording(s * (joint == j)) for s in square])
            best = np.argmin(left, axis=0)
            chosen[..., j, 0] = np.take_along_axis(angles[..., j], best[None], axis=0)[0]
        return chosen

    def _step(self, error: np.ndarray, moving: list[Unknowns], njoint: int) -> np.ndarray:
        """Gauss and Newton's, with what is expected as the prior, (m, nrec, njoint, 3).

        Args:
            error: (1 + len(moving), m, k) as it is, and with some unknowns a step further. What
                is moved together moves its own joint only.
        """
        unknowns = [one for some in moving for one in some]
        at_joint, of_kind = np.array(unknowns).T
        moved = np.repeat(error[1:] - error[0], [len(some) for some in moving], axis=0)
        if len(unknowns) > len(moving):
            moved *= (self.wanted[3] == at_joint[:, None])[:, None]
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
        """(n,), of a joint without a far side no more than its doubt."""
        far = {joint for joint, kind in unknowns if kind != VELOCITY}
        return np.array(
            [EXPECTED[kind] if j in far else self.doubt[record, j] for j, kind in unknowns]
        )


def _moved(start: np.ndarray, moving: list[Unknowns]) -> np.ndarray:
    """`start` (m, nrec, njoint, 3), then some of the unknowns a step further, and others."""
    moved = np.repeat(start[None], 1 + len(moving), axis=0)
    for i, unknowns in enumerate(moving):
        for joint, kind in unknowns:
            moved[1 + i, ..., joint, kind] += STEPS[kind]
    return moved
