"""A virtual robot for those without hardware: finer physics than any simulator that is trained in.

Motor and link are two masses with a spring between them, friction is LuGre's, the controller runs
at its own rate on what encoders show, and commands arrive late:

    τ = Kp (q_des − q) − Kd q̇,   |τ| and |dτ/dt| limited

Every robot of a batch is independent: rollouts run side by side.
"""

import os
from pathlib import Path

import mujoco
import numpy as np
from pydantic import Field

from t2l.hardware.backend import Backend, BackendError
from t2l.hardware.features import Features, State
from t2l.hardware.lugre import LuGre
from t2l.hardware.virtual_physics import VirtualPhysics, read
from t2l.robots import Robot, plant
from t2l.sim.batch import diverged, make_batch
from t2l.sim.controllers.joint_pd import pd_torque
from t2l.typed import Typed


class Settings(Typed):
    """Whose physics."""

    physics: str | None = Field(
        None,
        min_length=1,
        description="YAML of what the MJCF does not say, for a robot of your own; one of the "
        "library's robots has its own",
    )


class VirtualRobot(Backend):
    """`n` virtual robots of a kind, each with gains of its own.

    Args:
        robot: what they are.
        threads: that simulate them, which change no result; by default one a core.
        physics: file of what the MJCF does not say; by default the library's for this robot.

    Raises:
        ConfigurationError: there is no such file, or it lacks something.
    """

    name = "virtual"
    settings = Settings

    @classmethod
    def features(cls, robot: Robot, settings: Settings) -> Features:
        """See `Backend.features`."""
        return Features(read(robot, settings.physics).control_rate_hz)

    @classmethod
    def open(cls, robot: Robot, settings: Settings, n: int = 1) -> "VirtualRobot":
        """See `Backend.open`."""
        return cls(robot, n, threads=1, physics=settings.physics)

    def __init__(
        self,
        robot: Robot,
        n: int = 1,
        threads: int | None = None,
        physics: Path | str | None = None,
    ):
        self._physics = physics = read(robot, physics)
        self.n, self.robot, joints = n, robot, robot.joints
        self.can = Features(physics.control_rate_hz)
        self.notes = f"the virtual {robot.name}"
        self._shape = (n, len(joints))
        self._substeps = round(physics.physics_rate_hz / physics.control_rate_hz)
        model = _model(physics, robot)
        self._batch = make_batch(model, n, threads or len(os.sched_getaffinity(0)))
        self._motor_q, self._motor_v = _addresses(model, joints)
        self._twist_q, self._twist_v = _addresses(model, [f"{name}/gear" for name in joints])
        inertia = model.dof_armature[self._motor_v]
        self._friction = LuGre(
            stiffness=physics.bristle_stiffness,
            damping=2
            * physics.bristle_damping_ratio
            * np.sqrt(physics.bristle_stiffness * inertia),
            coulomb=physics.coulomb,
            static=physics.coulomb * physics.breakaway_ratio,
            stribeck_velocity=physics.stribeck_velocity,
        )
        self._late = round(physics.command_latency_s * physics.control_rate_hz)
        self._smoothing = 1 - np.exp(
            -2 * np.pi * physics.velocity_cutoff_hz / physics.control_rate_hz
        )
        self._gravity = self._batch.bind("qfrc_gravcomp")

    def start(self, q: np.ndarray, kp: np.ndarray, kd: np.ndarray) -> State:
        """See `Backend.start`; the robots rest where they are told to, bristles unbent."""
        batch = self._batch
        self._kp, self._kd = (np.broadcast_to(np.asarray(g, float), self._shape) for g in (kp, kd))
        batch.reset()
        batch.qpos[:, self._motor_q] = q
        batch.forward()
        # gears are wound up by the weight that they carry
        twist = -self._gravity[:, self._twist_v] / self._physics.gear_stiffness
        batch.qpos[:, self._twist_q] = twist
        batch.qpos[:, self._motor_q] -= twist
        batch.forward()
        self._bent = np.zeros(self._shape)
        self._torque = np.zeros(self._shape)
        self._q, self._dq = self._encoders(), np.zeros(self._shape)
        self._pending = [self._q.copy() for _ in range(self._late)]
        return self.read()

    def read(self) -> State:
        """See `Backend.read`."""
        return State(self._q.copy(), self._dq.copy(), self._torque.copy())

    def send(self, q_des: np.ndarray, period_s: float) -> None:
        """See `Backend.send`."""
        for _ in range(round(period_s * self.can.control_rate_hz)):
            self._pending.append(np.broadcast_to(q_des, self._shape).copy())
            self._tick(self._pending.pop(0))
        if diverged(self._batch).any():
            which = np.flatnonzero(diverged(self._batch)).tolist()
            raise BackendError(
                f"virtual robot {which}: the simulation runs away under Kp up to "
                f"{self._kp.max():g} and Kd up to {self._kd.max():g}"
            )

    def hold(self) -> None:
        """Nothing to brake: nobody stands beside it."""

    def close(self) -> None:
        """Nothing to release."""

    def _tick(self, q_des: np.ndarray) -> None:
        batch, physics = self._batch, self._physics
        period = 1 / self.can.control_rate_hz
        wanted = pd_torque(q_des, self._q, self._dq, self._kp, self._kd)
        reach = physics.torque_rate_limit * period
        wanted = np.clip(wanted, self._torque - reach, self._torque + reach)
        self._torque = np.clip(wanted, -physics.torque_limit, physics.torque_limit)
        held = self._torque + physics.torque_offset
        for _ in range(self._substeps):
            self._bent, friction = self._friction.advance(
                self._bent, batch.qvel[:, self._motor_v], batch.model.opt.timestep
            )
            batch.qfrc_applied[:, self._motor_v] = held + friction
            # gravity is compensated by the motor, and passes through the gear
            batch.qfrc_applied[:, self._twist_v] = -self._gravity[:, self._twist_v]
            batch.step()
        q = self._encoders()
        self._dq = self._dq + self._smoothing * ((q - self._q) / period - self._dq)
        self._q = q

    def _encoders(self) -> np.ndarray:
        """Link angles (n, njoint) as encoders show them, rad."""
        q = self._batch.qpos[:, self._motor_q] + self._batch.qpos[:, self._twist_q]
        resolution = self._physics.encoder_resolution_rad
        return np.round(q / resolution) * resolution


def _model(physics: VirtualPhysics, robot: Robot) -> mujoco.MjModel:
    spec = plant.load(robot.name, robot.joints)
    spec.option.timestep = 1 / physics.physics_rate_hz
    spec.option.solver = mujoco.mjtSolver.mjSOL_NEWTON
    for i, name in enumerate(robot.joints):
        motor = spec.joint(name)
        motor.frictionloss = 0.0
        motor.damping[:] = [physics.viscous[i], 0, 0]
        gear = motor.parent.add_joint(
            name=f"{name}/gear", type=motor.type, axis=motor.axis, pos=motor.pos
        )
        stiffness = physics.gear_stiffness[i]
        damping = 2 * physics.gear_damping_ratio[i] * np.sqrt(stiffness * motor.armature)
        gear.stiffness[:] = [stiffness, 0, 0]
        gear.damping[:] = [damping, 0, 0]
        gear.frictionloss = gear.armature = 0.0
        gear.limited = 0
    return spec.compile()


def _addresses(model: mujoco.MjModel, names) -> tuple[np.ndarray, np.ndarray]:
    joints = [model.joint(name) for name in names]
    return (
        np.array([joint.qposadr[0] for joint in joints]),
        np.array([joint.dofadr[0] for joint in joints]),
    )
