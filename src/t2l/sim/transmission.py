"""What lies between motors and links: springs, and play that springs close.

An encoder shows one side of a joint. The other, hidden side follows it like a mass on a spring:

    J ë + d ė + k z(e) = u,    z(e) = e less half the play to either side, zero within it

with e by how much the hidden side is behind what the motion shown, rigid, takes (u, N·m). On the
link's inertia u is what the link takes; on the rotor's, what the motor gives beyond the rotor.

Source: Spong, Modeling and control of elastic joint robots, 1987, eq. 15; with play, Nordin and
Gutman, Controlling mechanical systems with backlash, 2002.
"""

from dataclasses import dataclass, fields

import numpy as np

# numerics: weight of a step's end: a half keeps energy, more damps what is too fast for the steps
IMPLICIT = 0.52
STEP = 0.4  # numerics: radians of the fastest oscillation in a step
MOST_STEPS = 8  # numerics: a tick


@dataclass
class Transmission:
    """Of joints; arrays of one shape.

    Attributes:
        stiffness: N·m/rad, infinite where motor and link are one.
        damping: N·m·s/rad.
        play: rad, within which the link is free of the motor.
        on_link: 1 where the encoder shows the link, else 0.
    """

    stiffness: np.ndarray
    damping: np.ndarray
    play: np.ndarray
    on_link: np.ndarray

    @classmethod
    def rigid(cls, shape: tuple[int, ...]) -> "Transmission":
        """Of joints that do not give."""
        nothing = (np.zeros(shape) for _ in range(3))
        return cls(np.full(shape, np.inf), *nothing)

    @property
    def gives(self) -> np.ndarray:
        """Where motor and link are two, bool."""
        return np.isfinite(self.stiffness)

    def of(self, *index) -> "Transmission":
        """Of some joints."""
        return Transmission(*(getattr(self, field.name)[index] for field in fields(self)))


def hidden_acceleration(
    give: Transmission, inertia: np.ndarray, torque: np.ndarray, period_s: float
) -> np.ndarray:
    """ë (ntick, m, nrec, k), rad/s² on average until the next tick; at first e rests.

    Args:
        give: (m, nrec, k) joints, all of which give.
        inertia: (ntick, m or 1, nrec, k, k) kg·m² of the hidden sides.
        torque: u (ntick, m, nrec, k), N·m, held until the next tick.
    """
    k, d, half = give.stiffness, give.damping, give.play / 2
    own = np.diagonal(inertia[:: max(1, len(inertia) // 16)], axis1=-2, axis2=-1)
    fastest = period_s * float(np.sqrt(np.max(k / own.min(axis=0))))
    steps = int(np.clip(np.ceil(fastest / STEP), 1, MOST_STEPS))
    h, w = period_s / steps, IMPLICIT
    eye = np.eye(k.shape[-1])
    e, v = torque[0] / k + half * np.sign(torque[0]), np.zeros_like(k)
    out = np.empty(torque.shape, np.float32)
    for tick in range(len(torque)):
        before, u, mass = v, torque[tick], inertia[tick]
        for _ in range(steps):
            ahead = e + h * v
            side = np.where(np.abs(ahead) > half, np.sign(ahead), 0.0)
            closed = np.abs(side)
            spring, damper = closed * k, closed * d
            push = h * (u - spring * (e + w * h * v) + spring * side * half - damper * v)
            holds = h * w * (damper + h * w * spring)
            if len(eye) == 1:
                more = push / (mass[..., 0] + holds)
            else:
                whole = mass + holds[..., None] * eye
                more = np.linalg.solve(whole, push[..., None])[..., 0]
            e = e + h * (v + w * more)
            v = v + more
        out[tick] = (v - before) / period_s
    return out
