"""Motions to record: functions of time that return displacements from the home pose.

Every maker takes a random generator, an amplitude per joint [rad] and the duration [s], and
returns a `Command`, which maps times (K,) [s] to displacements (K, joints) [rad]. All start at
zero displacement.
"""

from collections.abc import Callable

import numpy as np

Command = Callable[[np.ndarray], np.ndarray]

FADE_S = 0.5


def _fade_in(t: np.ndarray) -> np.ndarray:
    return _smooth(np.clip(t / FADE_S, 0, 1))[:, None]


def _smooth(s: np.ndarray) -> np.ndarray:
    """Minimum-jerk step from 0 to 1."""
    return s**3 * (10 - 15 * s + 6 * s**2)


def multisine(rng, amplitude, duration_s, band_hz=(0.2, 2.0), count=6) -> Command:
    """Sines of random phase, amplitudes falling as 1/f, their sum about `amplitude` at most."""
    n = len(amplitude)
    f = np.geomspace(*band_hz, count)[:, None] * rng.uniform(0.9, 1.1, (count, n))
    phase = rng.uniform(0, 2 * np.pi, (count, n))
    weights = 1 / f
    weights *= amplitude / (0.75 * weights.sum(axis=0))

    def command(t):
        angle = 2 * np.pi * f * t[:, None, None] + phase
        return _fade_in(t) * np.sum(weights * np.sin(angle), axis=1)

    return command


def slow_sine(rng, amplitude, duration_s, frequency_hz=0.3) -> Command:
    """One slow sine per joint, joints at slightly different frequencies."""
    n = len(amplitude)
    f = frequency_hz * rng.uniform(0.8, 1.2, n)
    sign = rng.choice([-1, 1], n)
    return lambda t: _fade_in(t) * sign * amplitude * np.sin(2 * np.pi * f * t[:, None])


def triangle(rng, amplitude, duration_s, frequency_hz=0.4) -> Command:
    """Constant speeds and sharp reversals."""
    n = len(amplitude)
    f = frequency_hz * rng.uniform(0.8, 1.2, n)
    sign = rng.choice([-1, 1], n)

    def command(t):
        return sign * amplitude * 2 / np.pi * np.arcsin(np.sin(2 * np.pi * f * t[:, None]))

    return command


def chirp(rng, amplitude, duration_s, band_hz=(0.2, 3.0)) -> Command:
    """Frequency rising exponentially, amplitude falling with its square root."""
    low, high = band_hz
    growth = np.log(high / low) / duration_s
    shift = rng.uniform(0, 2 * np.pi, len(amplitude))

    def command(t):
        t = t[:, None]
        angle = 2 * np.pi * low * np.expm1(growth * t) / growth
        return _fade_in(t[:, 0]) * amplitude * np.exp(-growth * t / 2) * np.sin(angle + shift)

    return command


def steps(rng, amplitude, duration_s, hold_s=0.7) -> Command:
    """Jumps to random targets, the first after `hold_s` / 2."""
    targets = _targets(rng, amplitude, duration_s, hold_s)
    return lambda t: targets[np.floor(t / hold_s + 0.5).astype(int)]


def smooth_steps(rng, amplitude, duration_s, hold_s=0.8, rise_s=0.4) -> Command:
    """Minimum-jerk moves of `rise_s` between random targets, with rests between."""
    targets = _targets(rng, amplitude, duration_s, hold_s)

    def command(t):
        i = np.floor(t / hold_s).astype(int)
        s = _smooth(np.clip((t - i * hold_s) / rise_s, 0, 1))[:, None]
        return targets[i] + s * (targets[i + 1] - targets[i])

    return command


def _targets(rng, amplitude, duration_s, hold_s) -> np.ndarray:
    count = int(duration_s / hold_s) + 3
    targets = amplitude * rng.uniform(0.4, 1.0, (count, len(amplitude)))
    targets *= rng.choice([-1, 1], targets.shape)
    targets[0] = 0.0
    return targets


COMMANDS = {
    maker.__name__: maker for maker in (multisine, slow_sine, triangle, chirp, steps, smooth_steps)
}
