"""The training simulator: position actuators with six parameters each, at coarse timesteps.

The study's simulator has, per actuator, stiffness, damping, armature and a joint friction of
three numbers: static friction, its ratio to dynamic friction, and viscous friction. A joint at
rest is held by up to the static friction; one that moves feels the dynamic friction and the
viscous one.
"""

from collections.abc import Mapping

import mujoco
import numpy as np

from t2l.robots import plant
from t2l.robots.fr3 import JOINTS, TORQUE_LIMIT
from t2l.sim.batch import apply_position_gains, make_batch

RATE_HZ = 100.0  # of the study's simulator
_TORQUE = np.array(TORQUE_LIMIT)
AT_REST_RAD_S = 1e-3  # slower joints feel static friction


class Simulator:
    """`n` FR3 arms in one batch, each with parameters of its own.

    Attributes:
        batch: the simulations; `qpos` and `qvel` are (n, 7).
        timestep_s: of the physics.
    """

    def __init__(self, n: int, rate_hz: float, threads: int = 1):
        self.n, self.timestep_s = n, 1.0 / rate_hz
        self.batch = make_batch(model(rate_hz), n, threads)
        # bound once: these are views that follow the batch
        self.qpos, self.qvel, self._ctrl = self.batch.qpos, self.batch.qvel, self.batch.ctrl
        self._armature = self.batch.expand("dof_armature")
        self._damping = self.batch.expand("dof_damping")
        self._friction = self.batch.expand("dof_frictionloss")
        self._static = self._dynamic = np.zeros((n, len(JOINTS)))
        self._stiffness = self._kd = np.ones((n, len(JOINTS)))

    def set_parameters(self, parameters: Mapping[str, np.ndarray]) -> None:
        """Take parameters as `actuator_parameters` names them, each broadcasting to (n, 7)."""
        p = {k: np.broadcast_to(v, (self.n, len(JOINTS))) for k, v in parameters.items()}
        self._stiffness, self._kd = p["stiffness"].copy(), p["damping"].copy()
        apply_position_gains(self.batch, JOINTS, self._stiffness, self._kd)
        self._armature[:] = p["armature"]
        self._damping[:] = p["viscous_friction"]
        self._static = p["static_friction"].copy()
        self._dynamic = self._static * p["dynamic_friction_ratio"]
        self.batch.set_const()

    def step(self, q_des: np.ndarray, nstep: int) -> None:
        """Hold commands q_des (n, 7) rad for `nstep` timesteps."""
        for _ in range(nstep):
            np.copyto(self._ctrl, self._within_torque_limits(q_des))
            moving = np.abs(self.qvel) > AT_REST_RAD_S
            np.copyto(self._friction, np.where(moving, self._dynamic, self._static))
            self.batch.step()

    def _within_torque_limits(self, q_des: np.ndarray) -> np.ndarray:
        """Commands that ask for no more than the torque limits at the beginning of a timestep.

        A force limit on the actuators would not do: MuJoCo steps a saturated actuator explicitly,
        and at 100 Hz that throws light, damped joints about.
        """
        damping = self._kd * self.qvel
        torque = self._stiffness * (q_des - self.qpos) - damping
        clipped = np.clip(torque, -_TORQUE, _TORQUE)
        if np.array_equal(clipped, torque):
            return q_des
        return self.qpos + (clipped + damping) / self._stiffness

    def simulate(
        self, q_des: np.ndarray, start_q: np.ndarray, start_dq: np.ndarray, nstep: int
    ) -> tuple[np.ndarray, np.ndarray]:
        """Positions and velocities (n, ncommand, 7) at the instants commands are given.

        Args:
            q_des: (ncommand, 7) or (ncommand, n, 7) rad, each held for `nstep` timesteps.
            start_q, start_dq: broadcasting to (n, 7).
        """
        self.batch.reset()
        self.qpos[:], self.qvel[:] = start_q, start_dq
        shape = (len(q_des), self.n, len(JOINTS))
        q, dq = np.empty(shape), np.empty(shape)
        for i, command in enumerate(q_des):
            q[i], dq[i] = self.qpos, self.qvel
            if i + 1 < len(q_des):
                self.step(command, nstep)
        return q.transpose(1, 0, 2), dq.transpose(1, 0, 2)


def model(rate_hz: float = RATE_HZ) -> mujoco.MjModel:
    """The arm with position actuators."""
    spec = plant.load("fr3", JOINTS)
    spec.option.timestep = 1.0 / rate_hz
    # stiff and heavily damped cells are stable at 100 Hz, see `t2l.sim.batch`
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_DISCRETE
    for name in JOINTS:
        joint = spec.joint(name)
        joint.actfrclimited = 0  # see `Simulator._within_torque_limits`
        joint.frictionloss = 0.1  # nonzero, so that friction is part of the compiled model
        joint.solimp_friction[:2] = 0.9999
        actuator = spec.add_actuator(name=name, target=name, trntype=mujoco.mjtTrn.mjTRN_JOINT)
        actuator.set_to_position(kp=100.0, kv=10.0)
    return spec.compile()
