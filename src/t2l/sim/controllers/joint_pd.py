"""Joint position control, by MuJoCo's own position actuators.

    τ = Kp (q_des − q) − Kd q̇

The actuators evaluate it at the end of a timestep (see `t2l.sim.batch`).
"""

import numpy as np
from mujoco.batch import Batch
from numpy.typing import ArrayLike

from t2l.sim.arrays import Array
from t2l.sim.batch import apply_position_gains, step
from t2l.sim.controllers.controller import Controller

# before the name of a joint, in the name of its command
COMMAND_PREFIX = "q_des."


def pd_torque(q_des: Array, q: Array, dq: Array, kp: Array | float, kd: Array | float) -> Array:
    """τ = Kp (q_des − q) − Kd q̇, in N·m, for arrays that broadcast together.

    Args:
        q_des, q: rad.
        dq: rad/s.
        kp, kd: N·m/rad and N·m·s/rad.
    """
    return kp * (q_des - q) - kd * dq


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


class JointPD(Controller):
    """A command is q_des (njoint,) in rad; gains may differ from joint to joint."""

    name = "joint_pd"
    units = ("N·m/rad", "N·m·s/rad")

    def __init__(self, model, arms, kp, kd):
        super().__init__(model, arms, kp, kd)
        self.command_names = tuple(f"{COMMAND_PREFIX}{joint}" for joint in self.joints)
        self.command_units = ("rad",) * len(self.joints)

    def install(self, batch: Batch) -> None:
        """See `Controller.install`."""
        apply_position_gains(batch, self.joints, self.kp, self.kd)

    def measured(self, batch: Batch) -> np.ndarray:
        """See `Controller.measured`: q."""
        return batch.qpos[:, self.qpos]

    def step(self, batch, command, running, nstep):
        """See `Controller.step`."""
        batch.bind("ctrl")[:, self.ctrl] = command
        step(batch, running, nstep=nstep)

    def solved(self, qpos, dq, torque):
        """See `Controller.solved`."""
        return position_command(qpos[:, self.qpos], dq, torque, self.kp, self.kd)

    def commands(self, qpos, dq, torque):
        """See `Controller.commands`.

        A torque acts over a whole timestep and the actuators evaluate the law at its end, so τ[k]
        goes with q[k+1] and q̇[k+1]; replayed at the rate of the recording, the commands reproduce
        it to numerical precision.
        """
        return self.solved(qpos[1:], dq[1:], torque[:-1])
