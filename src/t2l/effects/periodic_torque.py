"""A torque that swings with time, whatever the robot does."""

import numpy as np

from t2l.effects.effect import Effect, Parameter
from t2l.sim.loop import over_ticks

# bound: a period longer than most logs, and faster than a joint follows
SLOWEST_HZ, FASTEST_HZ = 0.02, 50.0
PER_PERIOD = 6  # numerics: frequencies tried while the phase at the end of a log turns once
MOST_PLACES = 1 << 24  # numerics: of a session in samples; days apart, no phase is kept


class PeriodicTorque(Effect):
    """τ = A sin(2π f t + φ), with t of the log's clock, which recordings of a session share."""

    name = "periodic_torque"
    title = "periodic torque"
    parameters = (
        Parameter("amplitude", "N·m", 0.0, 10.0, "largest torque, A", scale="torque"),
        Parameter("frequency", "Hz", SLOWEST_HZ, FASTEST_HZ, "f", neutral=np.nan),
        Parameter("phase", "rad", -30.0, 30.0, "where the clock is zero, φ", neutral=np.nan),
    )
    summary = "a torque that swings at a rate of its own: a fan, a pump, a swaying base"
    signature = "the error repeats in time, whatever is commanded"
    source = "τ = A sin(2π f t + φ)"
    remembers = False
    follows = "time"

    def export(self, to, joints, values):
        to.call(self.name, swing_in_time, joints, values)

    def install(self, loop, rows, joints, values):
        at, turn = (..., rows, loop.columns(joints)), 2 * np.pi * values["frequency"]

        @over_ticks
        def add(tick, q, dq, torque):
            clock = loop.clock_s(tick)[..., rows, :]
            torque[at] += values["amplitude"] * np.sin(turn * clock + values["phase"])

        loop.joint_torques.append(add)

    def starts(self, scales):
        one = np.ones_like(scales.torque)
        return [{"amplitude": 0.01 * scales.torque, "frequency": one, "phase": 0.0 * one}]

    def read_off(self, q, torque, clock_s):
        frequency = strongest_frequency(torque, clock_s)
        if not frequency:
            return None
        angle = 2 * np.pi * frequency * clock_s
        parts = np.stack([np.sin(angle), np.cos(angle), np.ones_like(angle)], axis=1)
        sine, cosine, _ = np.linalg.lstsq(parts, torque, rcond=None)[0]
        return {
            "amplitude": np.hypot(sine, cosine),
            "frequency": frequency,
            "phase": np.arctan2(cosine, sine),
        }


def strongest_frequency(torque: np.ndarray, clock_s: np.ndarray) -> float:
    """Hz, at which a torque (n,) swings most by the clock (n,) s; zero if no phase is kept."""
    period = np.median(np.diff(np.unique(clock_s)))
    place = np.round((clock_s - clock_s.min()) / period).astype(int)
    count = PER_PERIOD * (place.max() + 1)
    if count > MOST_PLACES:
        return 0.0
    spectrum = np.abs(np.fft.rfft(np.bincount(place, torque - torque.mean(), count)))
    frequencies = np.fft.rfftfreq(count, period)
    allowed = (frequencies > SLOWEST_HZ) & (frequencies < FASTEST_HZ)
    return frequencies[np.argmax(np.where(allowed, spectrum, -1.0))]


def swing_in_time(robot, joints, values):
    """Add A sin(2π f t + φ)."""
    angle = 2 * np.pi * values["frequency"] * (robot.data.time + 0.5 * robot.period_s)
    robot.torque[joints] += values["amplitude"] * np.sin(angle + values["phase"])
