"""Torque-to-position retargeting (TPR): the position commands that reproduce a torque trajectory.

The PD law of `t2l.sim.controllers.position`, solved for its command:

    q_des = q + Kp⁻¹ (τ + Kd q̇)

τ is what the position controller itself has to supply: net of gravity compensation where the
robot adds that. Because a torque acts over a whole timestep and the simulator evaluates the
controller at its end, τ[k] goes with q[k+1] and q̇[k+1]; replayed at the rate of the recording, the
commands then reproduce it to numerical precision.
"""

import numpy as np
from numpy.typing import ArrayLike

from t2l.demos.demonstration import Demonstration
from t2l.gains import Cell

HOLDS = ("mean", "sample")


def position_command(
    q: ArrayLike, dq: ArrayLike, torque: ArrayLike, kp: ArrayLike, kd: ArrayLike
) -> np.ndarray:
    """q_des in rad at which the PD law yields `torque`, for arrays that broadcast together.

    Args:
        q, dq: rad and rad/s at the time the controller is evaluated.
        torque: N·m.
        kp, kd: N·m/rad, above zero, and N·m·s/rad.
    """
    q, dq, torque = np.asarray(q), np.asarray(dq), np.asarray(torque)
    return q + (torque + kd * dq) / kp


def retarget(demonstration: Demonstration, arm: np.ndarray, cell: Cell) -> np.ndarray:
    """Commands for every step but the last, (n - 1, dof) rad.

    Args:
        arm: indices of the arm joints in the demonstration's qpos.
    """
    return position_command(
        q=demonstration.qpos[1:, arm],
        dq=demonstration.dq[1:],
        torque=demonstration.torque[:-1],
        kp=cell.kp,
        kd=cell.kd,
    )


def hold(commands: np.ndarray, steps: int, how: str) -> np.ndarray:
    """Commands for a controller that takes a new one every `steps` timesteps, (ceil(n/steps), dof).

    Args:
        commands: (n, dof), one per timestep.
        how: `mean` holds the mean over the time it is held, which keeps the impulse of the
            torque; `sample` holds the first, which lags by half the holding time.
    """
    starts = np.arange(0, len(commands), steps)
    if how == "sample":
        return commands[starts]
    lengths = np.diff([*starts, len(commands)])
    return np.add.reduceat(commands, starts, axis=0) / lengths[:, None]
