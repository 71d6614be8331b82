"""What passes between a policy and a robot, simulated or not."""

import numpy as np

from t2l.errors import ConfigurationError
from t2l.robots.fr3 import JOINTS

PROXIMAL = 4  # joints that share the first action scale


def observe(q: np.ndarray, dq: np.ndarray, errors: np.ndarray, action: np.ndarray) -> np.ndarray:
    """What a policy sees, (n, nobs) float32: state, what is left to do, and its last action."""
    return np.concatenate([q, dq, errors, action], axis=1).astype(np.float32)


def steps_held(rate_hz: float, policy_rate_hz: float, of_what: str) -> int:
    """How many steps at `rate_hz` an action is held for.

    Raises:
        ConfigurationError: no whole number of them.
    """
    steps = rate_hz / policy_rate_hz
    if abs(steps - round(steps)) > 1e-9:
        raise ConfigurationError(
            f"policy rate: found {policy_rate_hz:g} Hz; allowed: a divisor of {of_what} "
            f"{rate_hz:g} Hz"
        )
    return round(steps)


def per_joint(action_scale: tuple[float, float]) -> np.ndarray:
    """(7,) rad: α of joints 1 to 4 and 5 to 7."""
    return np.repeat(action_scale, [PROXIMAL, len(JOINTS) - PROXIMAL])


def command(q: np.ndarray, action: np.ndarray, scale: np.ndarray, ranges: np.ndarray) -> np.ndarray:
    """q_des = q + α ⊙ a within the joints' ranges, (n, 7) rad.

    Soft gains take commands far ahead of the arm, which no robot accepts beyond its ranges.

    Args:
        action: a, (n, 7) in [-1, 1].
        scale: α, (7,) rad.
        ranges: (7, 2) rad.
    """
    return np.clip(q + scale * action, ranges[:, 0], ranges[:, 1])
