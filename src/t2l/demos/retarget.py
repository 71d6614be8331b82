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
