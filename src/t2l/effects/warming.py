"""What changes while a machine warms up: from a first value to a last, by a time constant.

x(t) = x1 + (x0 − x1) e^(−t/T),   t of the log's clock, which recordings of a session share
"""

import numpy as np

from t2l.effects.effect import Parameter, Values
from t2l.sim.servo import ServoLoop

TIME_CONSTANT = Parameter(
    "time_constant", "s", 0.3, 1e4, "of the change, T", log=True, per_joint=False
)
TIMES_S = (3.0, 30.0)  # guess: first guesses of it
REFERENCE_C = 25.0  # format: at which a parameter has its stated value


def at(loop: ServoLoop, rows: slice, tick: int, values: Values) -> np.ndarray:
    """x (nrow, k) at a tick."""
    left = np.exp(-loop.clock_s(tick)[..., rows, :] / values["time_constant"])
    return values["at_end"] + (values["at_start"] - values["at_end"]) * left
