"""What lies between motors and links: springs, and play that springs close.

An encoder shows one side of a joint. The other, hidden side follows it like a mass on a spring:

    J ë + d ė + k z(e) = u,    z(e) = e less half the play to either side, zero within it

with e by how much the hidden side is behind what the motion shown, rigid, takes (u, N·m). On the
link's inertia u is what the link takes; on the rotor's, what the motor gives beyond the rotor.

Source: Spong, Modeling and control of elastic joint robots, 1987, eq. 15; with play, Nordin and
Gutman, Controlling mechanical systems with backlash, 2002.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields

import numpy as np

# numerics: weight of a step's end: a half keeps energy, more damps what is too fast for the steps
IMPLICIT = 0.52
STEP = 0.5  # numerics: radians of the fastest oscillation in a step
MOST_STEPS = 4  # numerics: a tick
SLOWLY_S = 0.01  # numerics: in which masses hardly change


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

    @classmethod
    def together(cls, some: Sequence["Transmission"]) -> "Transmission":
        """One after the other, along the first axis."""
        names = (field.name for field in fields(cls))
        return cls(*(np.concatenate([getattr(one, name) for one in some]) for name in names))

    @property
    def gives(self) -> np.ndarray:
        """Where motor and link are two, bool."""
        return np.isfinite(self.stiffness)

    def of(self, some) -> "Transmission":
        """Of some joints, by any index."""
        return self._each(lambda values: values[some])

    def reshaped(self, shape: tuple[int, ...]) -> "Transmission":
        """The same in another shape."""
        return self._each(lambda values: values.reshape(shape))

    def is_as(self, other: "Transmission") -> bool:
        """Whether all are as those of another, which may be fewer and serve for all."""
        names = (field.name for field in fields(self))
        return all((getattr(self, name) == getattr(other, name)).all() for name in names)

    def _each(self, change: Callable[[np.ndarray], np.ndarray]) -> "Transmission":
        return Transmission(*(change(getattr(self, field.name)) for field in fields(self)))


def hidden_motion(
    gives: Transmission,
    inertia: np.ndarray,
    torque: np.ndarray,
    period_s: float,
    weight: np.ndarray | None = None,
) -> tuple[np.ndarray, np.ndarray]:
    """ë and e (ntick, m, nrec, k), rad/s² and rad on average until the next tick.

    At first e rests.

    Args:
        gives: (m, nrec, k) joints, all of which give.
        inertia: (ntick, m, nrec, k, k) kg·m² of the hidden sides; there may be 1 for all m.
        torque: u (ntick, m, nrec, k), N·m, held until the next tick.
        weight: N·m/rad like inertia, by which u falls with e; none if it is not given.
    """
    stiffness, damping, half = gives.stiffness, gives.damping, gives.play / 2
    own = np.diagonal(inertia[:: max(1, len(inertia) // 16)], axis1=-2, axis2=-1)
    fastest = period_s * float(np.sqrt(np.max(stiffness / own.min(axis=0))))
    steps = int(np.clip(np.ceil(fastest / STEP), 1, MOST_STEPS))
    h = period_s / steps
    sides = _Sides(stiffness, damping, h)
    e, v = torque[0] / stiffness + half * np.sign(torque[0]), np.zeros_like(half)
    ddq, lag = np.empty((2, *torque.shape), np.float32)
    renewed = max(1, round(SLOWLY_S / period_s))
    for tick, u in enumerate(torque):
        before, began = v, e
        if weight is not None:
            u = u - (weight[tick] @ e[..., None])[..., 0]
        if tick % renewed == 0:
            sides.weigh(inertia[tick])
        for _ in range(steps):
            ahead = e + h * v
            side = np.sign(ahead) * (np.abs(ahead) > half)
            closed = np.abs(side)
            spring = closed * stiffness
            push = u - spring * (e + IMPLICIT * h * v - side * half) - closed * damping * v
            more = sides.moved(closed, push)
            e = e + h * (v + IMPLICIT * more)
            v = v + more
        ddq[tick], lag[tick] = (v - before) / period_s, (began + e) / 2
    return ddq, lag


class _Sides:
    """Hidden sides in a step of h: the mass that each has, and what holds it where it is closed."""

    def __init__(self, stiffness: np.ndarray, damping: np.ndarray, h: float):
        self.h, self.holds = h, h * IMPLICIT * (damping + h * IMPLICIT * stiffness)
        self.alone = stiffness.shape[-1] == 1
        self.mass = self.inverse = self.closed = np.zeros(0)

    def weigh(self, mass: np.ndarray) -> None:
        """Have other masses (m or 1, nrec, k, k)."""
        self.mass, self.closed = np.broadcast_to(mass, (*self.holds.shape, mass.shape[-1])), None

    def moved(self, closed: np.ndarray, push: np.ndarray) -> np.ndarray:
        """By how much torques (m, nrec, k) change the velocity."""
        if self.alone:
            return self.h * push / (self.mass[..., 0] + closed * self.holds)
        if self.closed is None:
            self.inverse = self._inverse(self.mass, closed * self.holds)
        else:
            # few teeth open or close in a step
            other = (closed != self.closed).any(axis=-1)
            if other.any():
                holds = closed[other] * self.holds[other]
                self.inverse[other] = self._inverse(self.mass[other], holds)
        self.closed = closed
        return self.h * (self.inverse @ push[..., None])[..., 0]

    @staticmethod
    def _inverse(mass: np.ndarray, holds: np.ndarray) -> np.ndarray:
        return np.linalg.inv(mass + holds[..., None] * np.eye(holds.shape[-1]))
