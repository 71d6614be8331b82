"""What a controller works with at a tick, for effects that change what it makes of it."""

import numpy as np

from t2l.sim.loop import Loop

LEAST_KP = 1e-9  # numerics: N·m/rad, in place of zero


def error_at(loop: Loop, at: tuple) -> np.ndarray:
    """q_des − q that Kp multiplies, in simulations and joints `at`, rad; for controller filters."""
    # a loop of coarse ticks looks ahead, see `t2l.sim.servo`
    ahead = loop.ahead[at] * loop.measured_dq[at]
    return loop.command[at] - loop.measured[at] - ahead


def error_of_torque(torque: np.ndarray, kp: np.ndarray) -> np.ndarray:
    """Position error that a torque takes, rad."""
    return torque / np.maximum(kp, LEAST_KP)


def delayed(past: list, signal: np.ndarray, ticks: np.ndarray) -> np.ndarray:
    """A signal (k,) as it was some ticks (k,) ago, linear between two; `past` keeps it.

    Before its first value a signal was what that is.
    """
    ticks = np.broadcast_to(ticks, signal.shape)
    whole = np.floor(ticks + 1e-9).astype(int)
    past.append(signal.copy())
    del past[: -(int(whole.max()) + 2)]
    known, last, each = np.array(past), len(past) - 1, np.arange(len(signal))
    newer, older = (known[np.maximum(last - ago, 0), each] for ago in (whole, whole + 1))
    return newer + (ticks - whole) * (older - newer)
