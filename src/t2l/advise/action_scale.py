"""How far a policy that learns by trying may move commands, under each pair of gains.

An action of −1 to 1 times a scale says how far a joint's command lies from where the joint is. The
least scale is what the motions to be made ask for: torque, dry friction and damping over Kp. The
largest is what the motor has for it: beyond τ_max/Kp an action asks for more torque than there is.
"""

from dataclasses import dataclass

import numpy as np

from t2l.advise.retargeted import commands
from t2l.advise.shown import Shown

MOTIONS = 0.9  # convention: of the motions, that are to be possible
SLOW = 0.1  # numerics: of the usual speed, below which dry friction grows with it


@dataclass(frozen=True)
class ActionScales:
    """From `low` to `high`, (cell, n) rad; `high` is infinite where no limit is known."""

    low: np.ndarray
    high: np.ndarray

    @property
    def room(self) -> np.ndarray:
        """(cell,) times that the least scale may be raised, the worst joint; below 1 it may not."""
        return (self.high / np.maximum(self.low, 1e-12)).min(axis=1)


def action_scales(
    shown: Shown,
    kp: np.ndarray,
    kd: np.ndarray,
    friction: np.ndarray,
    torque_limit: np.ndarray,
    steps: int,
) -> ActionScales:
    """Of gains (cell, n).

    Args:
        friction, torque_limit: (n,) N·m.
        steps: rows of a command.
    """
    most = []
    for q, dq, torque in zip(shown.q, shown.dq, shown.torque, strict=True):
        usual = np.sqrt(np.mean(dq**2, axis=0)) + 1e-12
        asked = torque + friction * np.tanh(dq / (SLOW * usual))
        lead = commands(q, dq, asked, kp, kd, steps) - q[::steps]
        most.append(np.abs(lead).max(axis=1))
    return ActionScales(np.quantile(most, MOTIONS, axis=0), torque_limit / kp)
