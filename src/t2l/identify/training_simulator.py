"""The training simulator: position actuators with six parameters each, at coarse timesteps.

The study's simulator has, per actuator, stiffness, damping, armature and a joint friction of
three numbers: static friction, its ratio to dynamic friction, and viscous friction. A joint at
rest is held by up to the static friction; one that moves feels the dynamic friction and the
viscous one.
"""

from collections.abc import Mapping

import mujoco
import numpy as np

from t2l.robots import Robot
from t2l.sim.arrays import Array, like, namespace
from t2l.sim.batch import MUJOCO, apply_position_gains, make_batch

AT_REST_RAD_S = 1e-3  # numerics: slower joints feel static friction


class Simulator:
    """`n` robots in one batch, each with parameters of its own.

    Args:
        spec: `t2l.robots.plant.position_controlled` of the robot, or a scene made of it without
            other joints.
        device: of the simulations, see `t2l.sim.batch.make_batch`.

    Attributes:
        batch: the simulations; `qpos` and `qvel` are (n, njoint).
        timestep_s: of the physics.
    """

    def __init__(
        self,
        robot: Robot,
        spec: mujoco.MjSpec,
        n: int,
        rate_hz: float,
        threads: int = 1,
        device: str = MUJOCO,
    ):
        self.robot, self.n, self.timestep_s = robot, n, 1.0 / rate_hz
        spec.option.timestep = self.timestep_s
        self.batch = make_batch(spec.compile(), n, threads, device)
        # bound once: these are views that follow the batch
        self.qpos, self.qvel, self._ctrl = self.batch.qpos, self.batch.qvel, self.batch.ctrl
        self._armature = self.batch.expand("dof_armature")
        self._damping = self.batch.expand("dof_damping")
        self._friction = self.batch.expand("dof_frictionloss")
        self._torque_limit = like(robot.torque_limit, self.qpos)
        none = like(np.zeros((n, len(robot.joints))), self.qpos)
        self._static = self._dynamic = none
        self._stiffness = self._kd = none + 1.0

    def set_parameters(self, parameters: Mapping[str, np.ndarray]) -> None:
        """Take parameters as `actuator_parameters` names them, each broadcasting to (n, njoint)."""
        shape = tuple(self._static.shape)
        p = {k: like(np.broadcast_to(v, shape).copy(), self.qpos) for k, v in parameters.items()}
        self._stiffness, self._kd = p["stiffness"], p["damping"]
        apply_position_gains(self.batch, self.robot.joints, self._stiffness, self._kd)
        self._armature[:] = p["armature"]
        self._damping[:] = p["viscous_friction"]
        self._static = p["static_friction"]
        self._dynamic = self._static * p["dynamic_friction_ratio"]
        self.batch.set_const()

    def step(self, q_des: Array, nstep: int) -> None:
        """Hold commands q_des (n, njoint) rad for `nstep` timesteps."""
        xp = namespace(self.qpos)
        for _ in range(nstep):
            self._ctrl[...] = self._within_torque_limits(q_des)
            moving = xp.abs(self.qvel) > AT_REST_RAD_S
            self._friction[...] = xp.where(moving, self._dynamic, self._static)
            self.batch.step()

    def _within_torque_limits(self, q_des: Array) -> Array:
        """Commands that ask for no more than the torque limits at the beginning of a timestep.

        A force limit on the actuators would not do: MuJoCo steps a saturated actuator explicitly,
        and at 100 Hz that throws light, damped joints about.
        """
        damping = self._kd * self.qvel
        torque = self._stiffness * (q_des - self.qpos) - damping
        xp, limit = namespace(torque), self._torque_limit
        within = self.qpos + (xp.clip(torque, -limit, limit) + damping) / self._stiffness
        return xp.where(xp.abs(torque) <= limit, q_des, within)

    def simulate(
        self, q_des: np.ndarray, start_q: np.ndarray, start_dq: np.ndarray, nstep: int
    ) -> tuple[np.ndarray, np.ndarray]:
        """Positions and velocities (n, ncommand, njoint) at the instants commands are given.

        Args:
            q_des: (ncommand, njoint) or (ncommand, n, njoint) rad, each held for `nstep` timesteps.
            start_q, start_dq: broadcasting to (n, njoint).
        """
        self.batch.reset()
        self.qpos[:], self.qvel[:] = start_q, start_dq
        shape = (len(q_des), *self._static.shape)
        q, dq = np.empty(shape), np.empty(shape)
        for i, command in enumerate(q_des):
            q[i], dq[i] = self.qpos, self.qvel
            if i + 1 < len(q_des):
                self.step(command, nstep)
        return q.transpose(1, 0, 2), dq.transpose(1, 0, 2)
