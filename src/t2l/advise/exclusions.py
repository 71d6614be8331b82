"""What speaks against gains on a joint, and why, in words for engineers.

What rules gains out is that the loop does not settle, or may not for what nobody knows of it. What
it costs to ring, to sag, or to ask for more than there is, the predicted error of a policy weighs:
in worlds where it was measured most policies worked with it (docs/advise.md).
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from t2l.advise.machine import Machine
from t2l.advise.responses import DELAY, MOTOR, VELOCITY, Responses
from t2l.advise.retargeted import Labels, Replayed

# convention: a gain margin of 6 dB; Åström and Murray, Feedback systems, 2008, section 11.3
LEAST_MARGIN = 2.0
# guess: of a machine whose effects were measured; twice what is usual for numbers to be off by
KNOWN_MARGIN = 1.25
# measured: times the least predicted error, beyond which nine policies in ten fail
HOPELESS = 4.0
# convention: quarter-amplitude decay, to which Ziegler and Nichols (1942) tuned, is ζ 0.21
MOST_OVERSHOOT = 0.5
# convention: one command in ten that motor or joint cannot follow
MOST_MISSED = 0.1
MOST_SAG_RAD = 0.1  # convention: the end of an arm of 0.6 m hangs 6 cm low

UNSTABLE, NEAR, RINGS, SAGS = "unstable", "near unstable", "rings", "sags"
BEYOND, SATURATED, APART = "beyond its range", "short of torque", "runs away"
KINDS = (UNSTABLE, NEAR, APART, RINGS, SAGS, BEYOND, SATURATED)
RULING = (UNSTABLE, NEAR, APART)


@dataclass(frozen=True)
class Objection:
    """What one joint has against one pair of gains.

    Attributes:
        cell, joint: indices.
        kind: one of `KINDS`.
        by: how many times beyond what is allowed; 1 is the limit.
        why: a sentence without its end.
    """

    cell: int
    joint: int
    kind: str
    by: float
    why: str


def objections(
    machine: Machine,
    kp: np.ndarray,
    kd: np.ndarray,
    found: Responses,
    labels: Labels | None = None,
    replay: Replayed | None = None,
    most_sag_rad: float = MOST_SAG_RAD,
    least_margin: float = LEAST_MARGIN,
) -> list[Objection]:
    """Of gains (cell, n), each with the first that there is, by cell and joint."""
    told = []
    for cell, joint in np.ndindex(kp.shape):
        asked = most_sag_rad, least_margin
        one = _Judge(machine, kp, kd, found, labels, replay, *asked, cell, joint)
        reason = one.first()
        if reason is not None:
            told.append(Objection(cell, joint, *reason))
    return told


@dataclass(frozen=True)
class _Judge:
    machine: Machine
    kp: np.ndarray
    kd: np.ndarray
    found: Responses
    labels: Labels | None
    replay: Replayed | None
    most_sag_rad: float
    least_margin: float
    cell: int
    joint: int

    def first(self) -> tuple[str, float, str] | None:
        found, at = self.found, (self.cell, self.joint)
        margin, over, sag = found.margin[at], found.overshoot[at], found.sag_rad[at]
        if margin == 0 or not np.isfinite(over):
            return UNSTABLE, np.inf, self._said(f"does not settle{self._cause(1)}")
        if margin < self.least_margin:
            text = f"would no longer settle at {margin:.2g} times these gains{self._cause(1)}"
            return NEAR, self.least_margin / margin, self._said(text)
        # of the joints, that with the least margin breaks it
        if not found.together[self.cell] and self.joint == found.margin[self.cell].argmin():
            text = "does not settle together with the other joints, though it does alone"
            return UNSTABLE, np.inf, self._said(text)
        if self.replay is not None and not np.isfinite(self.replay.rmse_rad[at]):
            return APART, np.inf, self._said("runs away from the demonstrations in simulation")
        if over > MOST_OVERSHOOT:
            text = (
                f"rings at {found.ring_hz[at]:.2g} Hz and passes a step's end by "
                f"{100 * over:.0f} %{self._cause(0)}"
            )
            return RINGS, over / MOST_OVERSHOOT, self._said(text)
        if sag > self.most_sag_rad:
            weight = np.abs(self.machine.weight[:, self.joint]).max()
            of = "its weight and dry friction" if weight else "dry friction"
            text = f"sags by up to {1e3 * sag:.0f} mrad under {of}"
            return SAGS, sag / self.most_sag_rad, self._said(text)
        return self._of_motions(at)

    def _of_motions(self, at: tuple[int, int]) -> tuple[str, float, str] | None:
        if self.labels is not None and self.labels.beyond[at] > MOST_MISSED:
            share = self.labels.beyond[at]
            text = (
                f"needs commands beyond its range in {100 * share:.0f} % of the demonstrations' "
                f"time, as they run {self.labels.lead_rad[at]:.2g} rad ahead"
            )
            return BEYOND, share / MOST_MISSED, self._said(text)
        if self.replay is None:
            return None
        share = self.replay.saturated[at]
        if share > MOST_MISSED:
            limit = self.machine.torque_limit[self.joint]
            text = (
                f"is asked for more than its {limit:g} N·m by {100 * share:.0f} % of the commands "
                "as they arrive"
            )
            return SATURATED, share / MOST_MISSED, self._said(text)
        return None

    def _said(self, what: str) -> str:
        at = self.cell, self.joint
        name = self.machine.joints[self.joint]
        return f"{name} at Kp {self.kp[at]:.4g}, Kd {self.kd[at]:.4g} {what}"

    def _cause(self, which: int) -> str:
        """What of the machine makes it so: that without which it would be allowed.

        Args:
            which: 0 of overshoot, 1 of margin.
        """
        at = which, self.cell, self.joint
        signals, j = self.machine.signals, self.joint
        said = {
            DELAY: f"torques and measurements come {1e3 * signals.delay_s[j]:.2g} ms late",
            MOTOR: f"its motor follows only up to {signals.motor_hz[j]:.2g} Hz",
            VELOCITY: f"its velocity is smoothed at {signals.velocity_hz[j]:.2g} Hz",
        }
        for name, without in self.found.without.items():
            good = without[at] >= self.least_margin if which else without[at] <= MOST_OVERSHOOT
            if good:
                return f", because {said[name]}"
        inertia = self.machine.inertia[:, j].mean()
        period = self.machine.signals.period_s
        # of the damping that a tick's hold leaves stable, two of these
        if self.machine.gain_factor[j, 1] * self.kd[self.cell, j] * period > inertia:
            return (
                f", because a loop of {1 / period:.0f} Hz is slow for so much damping of "
                f"{inertia:.2g} kg·m²"
            )
        if which == 1:
            # a torque that is held for a tick takes half a tick of Kp from the damping
            return (
                f", because a loop of {1 / period:.0f} Hz is slow for so much stiffness and so "
                "little damping"
            )
        return f", because Kd damps its {inertia:.2g} kg·m² too little"


def mildest(told: Sequence[Objection], joints: int) -> list[tuple[Objection, int]]:
    """By joint and kind: the mildest case, and of how many cells it is true."""
    found = []
    for joint in range(joints):
        for kind in KINDS:
            own = [one for one in told if (one.joint, one.kind) == (joint, kind)]
            if own:
                # of those without a measure, the one of least gains
                found.append((min(own, key=lambda one: (one.by, one.cell)), len(own)))
    return found
