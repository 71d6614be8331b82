"""How every joint of a machine answers under every pair of gains, and why, where it does badly."""

from dataclasses import dataclass, replace

import numpy as np

from t2l.advise.loop import (
    Sampled,
    Signals,
    closed,
    lag_s,
    margin,
    overshoot,
    radius,
    ring,
    sampled,
)
from t2l.advise.machine import Machine


@dataclass(frozen=True)
class Responses:
    """Of gains (cell, n), each joint with the others held, at its worst pose.

    Attributes:
        natural_hz: (cell, n) √(Kp/M)/2π, at the mean inertia.
        ring_hz, damping: of the least damped oscillation of the sampled loop; 0 and infinite where
            there is none.
        lag_s: on a ramp, delays of commands included.
        overshoot: share of a step; infinite where the loop does not settle.
        margin: times that both gains may rise before the loop no longer settles; 0 where it does
            not.
        together: (cell,) bool, whether the loop of all joints settles.
        sag_rad: by the weight and by dry friction, where the arm holds still.
        without: the same overshoot and margin, (2, cell, n), by what is taken away.
    """

    natural_hz: np.ndarray
    ring_hz: np.ndarray
    damping: np.ndarray
    lag_s: np.ndarray
    overshoot: np.ndarray
    margin: np.ndarray
    together: np.ndarray
    sag_rad: np.ndarray
    without: dict[str, np.ndarray]


DELAY, MOTOR, VELOCITY = "delay", "motor", "velocity"
LONGEST_DELAY_S = 0.05  # bound: no controller of joints is later
RESOLVED = 0.02  # numerics: of a tick


def responses(machine: Machine, kp: np.ndarray, kd: np.ndarray) -> Responses:
    """Of gains (cell, n) N·m/rad and N·m·s/rad, as the controller is told them."""
    cells, n = kp.shape
    parts = {key: np.empty((cells, n)) for key in ("ring_hz", "damping", "lag_s")}
    judged = np.empty((2, cells, n))
    own = machine.gain_factor
    natural = np.sqrt(own[:, 0] * kp / machine.inertia.mean(axis=0)) / (2 * np.pi)
    changes = _changes(machine.signals)
    without = {name: np.empty((2, cells, n)) for name in changes}
    for j in range(n):
        plant = sampled(machine.alone(j), machine.signals.period_s)
        gains = own[j, 0] * kp[:, j], own[j, 1] * kd[:, j]
        at, signals = _each(plant, cells), machine.signals.of(j)
        poses = len(plant.moved)
        spread = [np.repeat(gain, poses)[:, None] for gain in gains]
        about = np.repeat(natural[:, j], poses)
        judged[:, :, j] = _judged(at, poses, *spread, signals, about)
        for name, changed in changes.items():
            without[name][:, :, j] = _judged(at, poses, *spread, changed.of(j), about)
        loop = closed(at, *spread, signals)
        found = ring(loop)
        damping = found.damping.reshape(cells, poses)
        worst = damping.argmin(axis=1)[:, None]
        parts["damping"][:, j] = damping.min(axis=1)
        parts["ring_hz"][:, j] = np.take_along_axis(found.hz.reshape(cells, poses), worst, 1)[:, 0]
        lags = lag_s(loop)[:, 0].reshape(cells, poses).max(axis=1)
        parts["lag_s"][:, j] = lags + signals.command_delay_s[0]
    sag = (np.abs(machine.weight).max(axis=0) + machine.friction) / (own[:, 0] * kp)
    return Responses(
        natural, **parts, overshoot=judged[0], margin=judged[1],
        together=settles_together(machine, kp, kd), sag_rad=sag, without=without,
    )  # fmt: skip


def settles_together(machine: Machine, kp: np.ndarray, kd: np.ndarray) -> np.ndarray:
    """(cell,) whether the loop of all joints settles at every pose."""
    plant = sampled(machine.plant, machine.signals.period_s)
    poses = len(plant.moved)
    gains = (
        np.repeat(factor * gain, poses, axis=0)
        for factor, gain in zip(machine.gain_factor.T, (kp, kd), strict=True)
    )
    loop = closed(_each(plant, len(kp)), *gains, machine.signals)
    return (radius(loop) < 1).reshape(len(kp), poses).all(axis=1)


def _each(plant: Sampled, cells: int) -> Sampled:
    """All poses for every cell, cell after cell."""
    return plant.of(np.tile(np.arange(len(plant.moved)), cells))


def _judged(plant: Sampled, poses: int, kp, kd, signals: Signals, natural_hz) -> np.ndarray:
    """Overshoot and margin (2, cell), the worst of the poses of each cell."""
    over = overshoot(closed(plant, kp, kd, signals), natural_hz)
    bears = margin(plant, kp, kd, signals)
    shape = -1, poses
    return np.stack([over.reshape(shape).max(axis=1), bears.reshape(shape).min(axis=1)])


def _changes(signals: Signals) -> dict[str, Signals]:
    """The signals without each of the things that they have."""
    n, none = len(signals.delay_s), np.full(len(signals.delay_s), np.inf)
    found = {}
    if signals.delay_s.any():
        found[DELAY] = replace(signals, delay_s=np.zeros(n))
    if np.isfinite(signals.motor_hz).any():
        found[MOTOR] = replace(signals, motor_hz=none)
    if np.isfinite(signals.velocity_hz).any():
        found[VELOCITY] = replace(signals, velocity_hz=none)
    return found


def longest_delay_s(
    machine: Machine, kp: np.ndarray, kd: np.ndarray, least_margin: float
) -> np.ndarray:
    """(n,) s of delay in all that each joint's loop bears under gains (n,) with a margin.

    Of a joint at its mean inertia; `LONGEST_DELAY_S` where it bears that and more, 0 where nothing.
    """
    period, found = machine.signals.period_s, np.zeros(len(kp))
    for j, (stiff, damped) in enumerate(zip(kp, kd, strict=True)):
        plant = sampled(machine.alone(j).mean(), period)
        raised = [
            np.full((1, 1), least_margin * factor * gain)
            for factor, gain in zip(machine.gain_factor[j], (stiff, damped), strict=True)
        ]

        def bears(delay_s: float, plant=plant, raised=raised, joint=j) -> bool:
            late = replace(machine.signals.of(joint), delay_s=np.full(1, delay_s))
            return bool(radius(closed(plant, *raised, late))[0] < 1)

        if bears(LONGEST_DELAY_S):
            found[j] = LONGEST_DELAY_S
        elif bears(0.0):
            low, high = 0.0, LONGEST_DELAY_S
            while high - low > RESOLVED * period:
                middle = (low + high) / 2
                low, high = (middle, high) if bears(middle) else (low, middle)
            found[j] = low
    return found
