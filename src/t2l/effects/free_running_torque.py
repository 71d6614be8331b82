"""A torque that swings with time, and that no clock of the logs tells the phase of."""

import numpy as np

from t2l.effects.effect import Effect, Parameter
from t2l.effects.periodic_torque import FASTEST_HZ, PER_PERIOD, SLOWEST_HZ
from t2l.sim.loop import PHASE, over_ticks

LEAST_RECORDINGS = 2  # derived: of one, a phase that is free and one that is told are the same


class FreeRunningTorque(Effect):
    """τ = A sin(2π f t + φ), t since the start, with another φ of each joint in each recording.

    φ is no parameter. It is how the oscillation begins, and free, as all is that nobody sees of a
    beginning: see `t2l.identify.hidden_state`. Where nothing is recorded, as of an exported robot
    or in training, it is zero.
    """

    name = "free_running_torque"
    title = "free-running periodic torque"
    parameters = (
        Parameter("amplitude", "N·m", 0.0, 10.0, "largest torque, A", scale="torque"),
        Parameter("frequency", "Hz", SLOWEST_HZ, FASTEST_HZ, "f", neutral=np.nan),
    )
    summary = "a torque that swings at a rate of its own, and begins anywhere in each recording"
    signature = "the error repeats in time at one rate, and begins anywhere in each recording"
    source = (
        "Francis and Wonham, The internal model principle of control theory, 1976: a disturbance "
        "of known form from a state nobody knows"
    )
    remembers = False
    contains = ("periodic_torque",)
    follows = "time"
    swings = True
    reads = ("recording",)

    def export(self, to, joints, values):
        to.call(self.name, swing_freely, joints, values)

    def may_act(self, recordings):
        return len(recordings) >= LEAST_RECORDINGS and super().may_act(recordings)

    def install(self, loop, rows, joints, values):
        columns, turn = loop.columns(joints), 2 * np.pi * values["frequency"]

        @over_ticks
        def add(tick, q, dq, torque):
            begins = loop.hidden_start[rows, columns, PHASE]
            angle = turn * loop.elapsed_s(tick)[..., rows, :] + begins
            torque[..., rows, columns] += values["amplitude"] * np.sin(angle)

        loop.joint_torques.append(add)

    def starts(self, scales):
        one = np.ones_like(scales.torque)
        return [{"amplitude": 0.01 * scales.torque, "frequency": one}]

    def oscillation(self, values):
        return values["amplitude"], values["frequency"]

    def read_off(self, q, torque, clock_s, recording):
        each = [recording == r for r in np.unique(recording)]
        parts = [(torque[at], clock_s[at]) for at in each]
        frequency = strongest_line(parts)
        if not frequency:
            return None
        square, count = 0.0, 0
        for own, clock in parts:
            angle = 2 * np.pi * frequency * clock
            waves = np.stack([np.sin(angle), np.cos(angle), np.ones_like(angle)], axis=1)
            sine, cosine, _ = np.linalg.lstsq(waves, own, rcond=None)[0]
            square, count = square + len(own) * (sine**2 + cosine**2), count + len(own)
        return {"amplitude": np.sqrt(square / count), "frequency": frequency}

    def also(self, guess):
        # what shakes one joint may shake others, where more is missing
        return [
            guess | {"frequency": np.full_like(guess["frequency"], hz)}
            for hz in dict.fromkeys(guess["frequency"].tolist())
        ]


def strongest_line(parts: list[tuple[np.ndarray, np.ndarray]]) -> float:
    """Hz at which torques swing most, from whatever phase each; zero if none is long enough.

    The spectra of all are added, as powers (Bartlett, 1948). The slowest that counts has a period
    in the longest of them.

    Args:
        parts: torque (n,) and clock (n,) s, of each recording.
    """
    parts = [(torque, clock - clock.min()) for torque, clock in parts if len(clock) > 1]
    if not parts:
        return 0.0
    period = np.median(np.concatenate([np.diff(np.unique(clock)) for _, clock in parts]))
    longest = max(clock.max() for _, clock in parts)
    count = PER_PERIOD * (int(np.round(longest / period)) + 1)
    power = 0.0
    for torque, clock in parts:
        place = np.round(clock / period).astype(int)
        power = power + np.abs(np.fft.rfft(np.bincount(place, torque - torque.mean(), count))) ** 2
    frequencies = np.fft.rfftfreq(count, period)
    allowed = (frequencies * longest >= 1) & (frequencies > SLOWEST_HZ) & (frequencies < FASTEST_HZ)
    return float(frequencies[np.argmax(np.where(allowed, power, -1.0))]) if allowed.any() else 0.0


def swing_freely(robot, joints, values):
    """Add A sin(2π f t)."""
    angle = 2 * np.pi * values["frequency"] * (robot.data.time + 0.5 * robot.period_s)
    robot.torque[joints] += values["amplitude"] * np.sin(angle)
