"""Whether a joint follows its commands closely, and so whether a data set does.

The study (its Sec. II-C, Fig. 3) calls it close where "achieved positions closely track commands
with minimal lag and overshoot", and gives no number. Here both words have one:

- minimal lag: at most one row of DROID, the largest data set that it shows, recorded at 15 Hz
  (Khazatsky et al., 2024). A smaller lag cannot be seen there.
- minimal overshoot: at most 5 % of a step. A second-order system overshoots by
  exp(−π ζ / √(1 − ζ²)), which is 5 % at ζ 0.69. ζ is fitted to every motion, steps or none.
"""

from collections.abc import Sequence

import numpy as np

from t2l.response.joints import JointResponse

LONGEST_LAG_S = 1 / 15  # reference: a row of DROID
LARGEST_OVERSHOOT = 0.05  # convention: the usual settling band of control engineering


def least_damping(overshoot: float) -> float:
    """ζ of the second-order system that passes a step's end by that share of the step."""
    size = np.log(overshoot)
    return float(-size / np.hypot(np.pi, size))


LEAST_DAMPING = least_damping(LARGEST_OVERSHOOT)


def follows_closely(lag_s: tuple[float, float], zeta: tuple[float, float]) -> bool | None:
    """Of the 95 % intervals of lag and ζ; NaN where an end is not told.

    Returns:
        True if both lie whole on the close side, False if one lies whole on the other, else None.
    """
    if lag_s[1] <= LONGEST_LAG_S and zeta[0] >= LEAST_DAMPING:
        return True
    if lag_s[0] > LONGEST_LAG_S or zeta[1] < LEAST_DAMPING:
        return False
    return None


def joint_follows_closely(response: JointResponse) -> bool | None:
    """The same of a joint; one that does not move, though commanded, does not follow."""
    if not response.fit.moves:
        return False
    unknown, lag = (np.nan, np.nan), response.lag
    # too short a recording for an interval: its lag is taken as it is
    late = unknown if lag is None else lag.interval or (lag.seconds, lag.seconds)
    told = np.isfinite(response.fit.covariance).all()
    return follows_closely(late, response.fit.interval(1) if told else unknown)


def most(joints: Sequence[bool | None]) -> bool | None:
    """Whether more than half of those that are told are true; None at a tie, or if none is."""
    told = [one for one in joints if one is not None]
    if 2 * sum(told) == len(told):
        return None
    return 2 * sum(told) > len(told)
