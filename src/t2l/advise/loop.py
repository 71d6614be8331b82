"""A position loop as numbers: how it rings, lags and overshoots, how near it is to unstable.

    M q̈ + D q̇ + K q = τ,   τ = Kp (q_des − q) − Kd q̇,   renewed every h and held

The plant moves exactly between two ticks (zero-order hold). What the machine adds lies on the way
around the loop, as `t2l.effects` has it: a delay, linear between two ticks; a low-pass of the
measured velocity; a lag of the motor. Together they are x' = F x + G q_des, whose eigenvalues say
whether the loop settles. All loops are computed side by side; one of many joints counts as one.

Source: Åström and Wittenmark, Computer-controlled systems, 1997, sections 2.3, 3.2 and 3.3.
"""

from dataclasses import dataclass

import numpy as np
from scipy.linalg import expm

MOST_MARGIN = 16.0  # format: a loop that bears more is called that
HALVINGS = 14  # numerics: of a margin, to a part in a thousand
FASTEST = 1 / 4  # physics: of the ticks, a torque that changes its sign at every second one
STEPS = 256  # numerics: of a step response, over `PERIODS` natural periods
PERIODS = 1.5  # physics: up to ζ = 0.94 the peak comes within them


@dataclass(frozen=True)
class Plant:
    """What torque moves: k of them, of m degrees of freedom, n of them driven.

    Attributes:
        mass, stiffness: (k, m, m) kg·m² and N·m/rad.
        damping: (k, m) N·m·s/rad.
        drive: (m, n) where torques act.
        sense: (n, m) what encoders read of positions.
    """

    mass: np.ndarray
    damping: np.ndarray
    stiffness: np.ndarray
    drive: np.ndarray
    sense: np.ndarray

    def mean(self) -> "Plant":
        """One plant, the mean of all."""
        means = (values.mean(axis=0, keepdims=True) for values in (
            self.mass, self.damping, self.stiffness
        ))  # fmt: skip
        return Plant(*means, self.drive, self.sense)


@dataclass(frozen=True)
class Signals:
    """What lies between controller, motor and encoder, of n joints.

    Attributes:
        period_s: from tick to tick.
        delay_s: (n,) around the loop: of measurements and of torques.
        command_delay_s: (n,) of commands, beyond that of the loop, of which a loop feels nothing;
            below zero where it is the measurements that are late.
        velocity_hz, motor_hz: (n,) corners of low-passes, infinite without.
    """

    period_s: float
    delay_s: np.ndarray
    command_delay_s: np.ndarray
    velocity_hz: np.ndarray
    motor_hz: np.ndarray

    @classmethod
    def ideal(cls, period_s: float, n: int) -> "Signals":
        """Of a loop that has none of it."""
        zero, none = np.zeros(n), np.full(n, np.inf)
        return cls(period_s, zero, zero, none, none)

    def of(self, joint: int) -> "Signals":
        """Of one joint."""
        at = slice(joint, joint + 1)
        return Signals(
            self.period_s, self.delay_s[at], self.command_delay_s[at], self.velocity_hz[at],
            self.motor_hz[at],
        )  # fmt: skip


@dataclass(frozen=True)
class Loop:
    """x' = F x + G q_des from tick to tick, and the measured positions H x.

    Attributes:
        f: (k, N, N); g: (k, N, n), of commands at the tick; h: (n, N).
        period_s: of a tick.
    """

    f: np.ndarray
    g: np.ndarray
    h: np.ndarray
    period_s: float


@dataclass(frozen=True)
class Sampled:
    """Plants over a tick, whatever the gains.

    Attributes:
        moved: (k, 2m, 2m) what a tick makes of (q, q̇); pushed: (k, 2m, n) of torques held over it.
        sense: as of a `Plant`.
    """

    moved: np.ndarray
    pushed: np.ndarray
    sense: np.ndarray

    def of(self, which: np.ndarray) -> "Sampled":
        """Those of some indices, in that order."""
        return Sampled(self.moved[which], self.pushed[which], self.sense)


def sampled(plant: Plant, period_s: float) -> Sampled:
    """The exact motion of plants under torques that are held for a tick."""
    k, m = plant.damping.shape
    lighter = np.linalg.inv(plant.mass)
    rates = np.zeros((k, 3 * m, 3 * m))
    rates[:, :m, m : 2 * m] = np.eye(m)
    rates[:, m : 2 * m, :m] = -lighter @ plant.stiffness
    rates[:, m : 2 * m, m : 2 * m] = -lighter * plant.damping[:, None]
    rates[:, m : 2 * m, 2 * m :] = lighter
    held = expm(rates * period_s)[:, : 2 * m]
    return Sampled(held[..., : 2 * m], held[..., 2 * m :] @ plant.drive, plant.sense)


def closed(plant: Sampled, kp: np.ndarray, kd: np.ndarray, signals: Signals) -> Loop:
    """The loops of controllers (k, n) around k plants.

    Args:
        kp, kd: N·m/rad and N·m·s/rad.
    """
    k, (n, m) = len(kp), plant.sense.shape
    period = signals.period_s
    ticks = signals.delay_s / period
    whole = np.floor(ticks + 1e-9).astype(int)
    part = ticks - whole
    filtered, lagged = np.isfinite(signals.velocity_hz).any(), np.isfinite(signals.motor_hz).any()
    # torques that were asked for: with a part of a tick, one more of them
    kept = int((whole + (part > 1e-9)).max(initial=0))
    sizes = [2 * m, n * filtered, n * lagged, *[n] * kept]
    ends = np.cumsum(sizes)
    state = np.eye(ends[-1] + n)  # of the rows of (x, q_des)

    def rows(block: int) -> np.ndarray:
        return state[ends[block] - sizes[block] : ends[block]]

    x, command = rows(0), state[ends[-1] :]
    position, speed = plant.sense @ x[:m], plant.sense @ x[m:]
    parts = []
    if filtered:
        keep = np.exp(-2 * np.pi * signals.velocity_hz * period)[:, None]
        speed = speed + (rows(1) - speed) * keep
        parts.append(np.broadcast_to(speed, (k, *speed.shape)))
    asked = kp[..., None] * (command - position) - kd[..., None] * speed
    past = [asked, *(np.broadcast_to(rows(3 + i), asked.shape) for i in range(kept)), 0 * asked]
    given, joints = np.stack(past, axis=1), np.arange(n)
    sooner, later = given[:, whole, joints], given[:, whole + 1, joints]
    torque = sooner + part[:, None] * (later - sooner)
    if lagged:
        turns = 2 * np.pi * np.minimum(signals.motor_hz, 1e6)[:, None] * period
        gap = rows(2) - torque
        after, torque = torque + gap * np.exp(-turns), torque - gap * np.expm1(-turns) / turns
        parts.append(after)
    x = plant.moved @ x + plant.pushed @ torque
    whole_state = np.concatenate([x, *parts, *past[:kept]], axis=1)
    read = np.zeros((n, ends[-1]))
    read[:, :m] = plant.sense
    return Loop(whole_state[..., : ends[-1]], whole_state[..., ends[-1] :], read, period)


def radius(loop: Loop) -> np.ndarray:
    """(k,) factor by which what is slowest to fade grows, a tick; below 1 the loop settles."""
    return np.abs(np.linalg.eigvals(loop.f)).max(axis=1)


def margin(plant: Sampled, kp: np.ndarray, kd: np.ndarray, signals: Signals) -> np.ndarray:
    """(k,) times that all gains may be raised before the loop no longer settles.

    0 where it does not as it is; `MOST_MARGIN` where it bears that and more.
    """

    def settles(factor: np.ndarray) -> np.ndarray:
        more = factor[:, None]
        return radius(closed(plant, more * kp, more * kd, signals)) < 1

    low, high = np.zeros(len(kp)), np.full(len(kp), np.log(MOST_MARGIN))
    bears, holds = settles(np.exp(high)), settles(np.exp(low))
    for _ in range(HALVINGS):
        middle = (low + high) / 2
        good = settles(np.exp(middle))
        low, high = np.where(good, middle, low), np.where(good, high, middle)
    return np.where(~holds, 0.0, np.where(bears, MOST_MARGIN, np.exp(low)))


@dataclass(frozen=True)
class Ring:
    """The least damped oscillation of each loop, (k,); hz is 0 and damping infinite without one."""

    hz: np.ndarray
    damping: np.ndarray


def ring(loop: Loop) -> Ring:
    """By the eigenvalues λ: s = ln λ / h, f = Im s / 2π, ζ = −Re s / |s|.

    What is faster than `FASTEST` is no motion of a joint: it counts only if it fades last.
    """
    found = np.linalg.eigvals(loop.f).astype(complex)
    size = np.maximum(np.abs(found), 1e-12)
    rate = (np.log(size) + 1j * np.angle(found)) / loop.period_s
    turning = (rate.imag > 1e-9 / loop.period_s) & (size > 1e-9)
    last = size >= np.where(turning, size, 0.0).max(axis=1, keepdims=True)
    turning &= last | (rate.imag < 2 * np.pi * FASTEST / loop.period_s)
    damping = np.where(turning, -rate.real / np.maximum(np.abs(rate), 1e-12), np.inf)
    least = damping.argmin(axis=1)[:, None]
    hz = np.take_along_axis(np.where(turning, rate.imag, 0.0) / (2 * np.pi), least, 1)[:, 0]
    return Ring(hz, np.take_along_axis(damping, least, 1)[:, 0])


def lag_s(loop: Loop) -> np.ndarray:
    """(k, n) s that each joint is behind when all commands are ramps, once it goes on like them.

    Kd/Kp of a rigid joint without friction. `Signals.command_delay_s` comes on top.
    """
    inverse = np.linalg.inv(np.eye(loop.f.shape[1]) - loop.f)
    # x = a + b t under commands t: b = (I − F)⁻¹ G 1, a = −h (I − F)⁻¹ b
    moving = inverse @ loop.g.sum(axis=2, keepdims=True)
    return (loop.period_s * (loop.h @ inverse @ moving))[..., 0]


def overshoot(loop: Loop, natural_hz: np.ndarray) -> np.ndarray:
    """(k,) by how much of a step of its command a loop of one joint passes where it ends.

    Args:
        natural_hz: (k,) about, of the motion: the response is followed for `PERIODS` of it.
    """
    k, size = loop.f.shape[:2]
    ticks = np.maximum(PERIODS / (natural_hz * loop.period_s * STEPS), 1.0)
    # one more state, the command, which stays
    step = np.zeros((k, size + 1, size + 1))
    step[:, :size, :size], step[:, :size, size:], step[:, size, size] = loop.f, loop.g, 1.0
    for doubling in range(int(np.ceil(np.log2(ticks.max()))) if ticks.max() > 1 else 0):
        more = 2**doubling < ticks
        step[more] = step[more] @ step[more]
    end = np.linalg.solve(np.eye(size) - loop.f, loop.g)[..., 0] @ loop.h[0]
    x, most = np.zeros((k, size + 1)), np.zeros(k)
    x[:, size] = 1.0
    with np.errstate(over="ignore", invalid="ignore"):
        for _ in range(STEPS):
            x = (step @ x[..., None])[..., 0]
            most = np.maximum(most, x[:, :size] @ loop.h[0])
        return np.where(radius(loop) < 1, np.maximum(most / end - 1, 0.0), np.inf)
