"""Motions of known systems, without a simulation."""

import numpy as np

from t2l.response.track import Track, respond


def commands(duration_s=6.0, rate_hz=50.0, seed=0):
    """Times and commands (n,): steps among slow sines."""
    time = np.arange(round(duration_s * rate_hz)) / rate_hz
    levels = 0.2 * np.random.default_rng(seed).choice([-1, 0, 1], 100)
    return time, levels[(time / 0.4).astype(int)] + 0.1 * np.sin(2 * np.pi * 0.7 * time)


def rows(omega, zeta, delay_s=0.0, gain=1.0, noise=0.0, seed=0, **of):
    """Times, commands and positions of a second-order system that begins at its first command."""
    time, command = commands(seed=seed, **of)
    track = Track.of(time, command, command)
    forced = respond(track, omega, zeta, delay_s, command[0])[0]
    q = gain * (forced + command[0])
    return time, command, q + noise * np.random.default_rng(seed).normal(size=len(q))
