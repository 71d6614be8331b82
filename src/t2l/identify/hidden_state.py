"""How a log begins where no encoder looks: the far side of a spring or of play.

From rest it hangs where its load leaves it. In motion its angle and velocity against the motor are
estimated from the first moments of each recording, for every variant of the model anew, as the
initial state of a simulation error is (Ljung, System Identification, 1999, section 7.5): the first
samples depend on them linearly, nearly, so that few Gauss-Newton steps do. Play is not smooth: the
side on which the teeth touch is tried first.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from t2l.sim.schedule import Schedule

WINDOW_S = 0.3  # of a recording; the beginning fades, and what fades says nothing later
# of the far side's angle and velocity, and of the velocity that the encoder's own side is off by
STEPS = (1e-4, 1e-3, 1e-3)  # rad, rad/s and rad/s, of finite differences
EXPECTED = (0.05, 1.0, 1.0)  # likewise; more is taken for something else
UNKNOWN = len(STEPS)
SIDES = (-1.0, -0.5, 0.5, 1.0)  # of the play, from where the load leaves the teeth
ITERATIONS = 2  # of Gauss and Newton: the response is nearly linear


@dataclass(frozen=True)
class Beginning:
    """The first moments of the recordings of a group, of which some begin in motion.

    Then all of them may: one that begins where a motion turns looks as if it were at rest.

    Attributes:
        schedule: theirs, with fewer `sample_ticks`.
        wanted: as of `t2l.identify.simulation.simulate`, of the samples of `measured` alone.
        measured: (k,) rad.
        noise_rad: of a measured position.
    """

    schedule: Schedule
    wanted: tuple[np.ndarray, ...]
    measured: np.ndarray
    noise_rad: float

    def estimate(
        self, predict: Callable[[np.ndarray], np.ndarray], joints: list[int], play: np.ndarray
    ) -> np.ndarray:
        """Starts as of `t2l.sim.servo.ServoLoop.hidden_start`, (m, nrec, njoint, 3).

        Args:
            predict: position (c m, k) of c copies of m variants, from their starts
                (c m, nrec, njoint, 3).
            joints: indices of those that have a far side.
            play: (m, nrec, njoint) rad.
        """
        m, nrec, njoint = play.shape

        def errors(starts: np.ndarray) -> np.ndarray:
            """(c, m, k) of starts (c, m, nrec, njoint, 3)."""
            q = predict(starts.reshape(-1, nrec, njoint, UNKNOWN)).reshape(len(starts), m, -1)
            return np.nan_to_num(q - self.measured, nan=1e3)

        start = np.zeros((m, nrec, njoint, UNKNOWN))
        if play.any():
            start = self._side(errors, play)
        best, least = start, np.full((m, nrec), np.inf)
        for iteration in range(ITERATIONS + 1):
            moved = start[None] if iteration == ITERATIONS else _moved(start, joints)
            error = errors(moved)
            left = self._by_recording(error[0] ** 2)
            better = (left < least)[..., None, None]
            best, least = np.where(better, start, best), np.minimum(left, least)
            if iteration < ITERATIONS:
                start = best + np.where(better, self._step(error, joints, njoint), 0.0)
        return best

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

    def _step(self, error: np.ndarray, joints: list[int], njoint: int) -> np.ndarray:
        """Gauss and Newton's, with what is expected as the prior, (m, nrec, njoint, 3)."""
        unit = np.array(EXPECTED * len(joints))
        slopes = (error[1:] - error[0]) / np.array(STEPS * len(joints))[:, None, None]
        nrec = len(self.schedule.kp)
        step = np.zeros((error.shape[1], nrec, njoint, UNKNOWN))
        for record in range(nrec):
            at = self.wanted[0] == record
            for variant in range(error.shape[1]):
                scaled = (slopes[:, variant, at] * unit[:, None]).T / self.noise_rad
                normal = scaled.T @ scaled + np.eye(len(unit))
                pull = scaled.T @ error[0, variant, at] / self.noise_rad
                # the least step of many where simulations fell over: the prior is lost in rounding
                found = -np.linalg.lstsq(normal, pull)[0]
                step[variant, record, joints] = (found * unit).reshape(-1, UNKNOWN)
        return step


def _moved(start: np.ndarray, joints: list[int]) -> np.ndarray:
    """`start` (m, nrec, njoint, 3), then each unknown of `joints` a step further."""
    moved = np.repeat(start[None], 1 + UNKNOWN * len(joints), axis=0)
    for i, joint in enumerate(joints):
        for kind, step in enumerate(STEPS):
            moved[1 + UNKNOWN * i + kind, ..., joint, kind] += step
    return moved
