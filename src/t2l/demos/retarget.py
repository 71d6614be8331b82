"""Torque-to-position retargeting (TPR): the commands that reproduce a torque trajectory.

A controller solved for its command: for joint position control

    q_des = q + Kp⁻¹ (τ + Kd q̇)

τ is what the controller itself has to supply: net of gravity compensation where the robot adds that
(see `t2l.sim.controllers`, each of which states its own law).
"""

import numpy as np

from t2l.demos.demonstration import Demonstration
from t2l.sim.controllers import Controller

HOLDS = ("mean", "sample")


def retarget(demonstration: Demonstration, controller: Controller) -> np.ndarray:
    """Commands for every step but the last, (n - 1, ncommand)."""
    return controller.commands(demonstration.qpos, demonstration.dq, demonstration.torque)


def hold(commands: np.ndarray, steps: int, how: str, controller: Controller) -> np.ndarray:
    """Commands that are renewed every `steps` timesteps, (ceil(n/steps), ncommand).

    Args:
        commands: (n, ncommand), one per timestep.
        how: `mean` holds the mean over the time it is held, which keeps the impulse of the
            torque; `sample` holds the first, which lags by half the holding time.
    """
    starts = np.arange(0, len(commands), steps)
    return commands[starts] if how == "sample" else controller.mean(commands, starts)


def replayed(demonstration: Demonstration, steps: int, how: str) -> np.ndarray:
    """Where a replay is, about, before each held command: positions (ceil((n - 1)/steps), nq).

    A replay of first commands is late by half the hold.
    """
    starts = np.arange(0, len(demonstration) - 1, steps)
    late = steps // 2 if how == "sample" else 0
    return demonstration.qpos[np.maximum(starts - late, 0)]
