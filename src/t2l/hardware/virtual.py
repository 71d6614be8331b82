"""A virtual robot for those without hardware: finer physics than any simulator that is trained in.

Motor and link are two masses with a spring between them, friction is LuGre's, the controller runs
at its own rate on what encoders show, motors follow its torque with a lag, and commands come late:

    τ = Kp (q_des − q) − Kd q̇,   |τ| and |dτ/dt| limited,   τ̇_motor = 2π f (τ − τ_motor)

Between an observation and the set-point that a policy computes from it lies a latency, which every
`send` has. A motion that is known beforehand waits for no policy: `record` has none of it.
Every robot of a batch is independent: rollouts run side by side.
"""

import os
import zlib
from collections.abc import Iterable
from pathlib import Path
from typing import Annotated

import mujoco
import numpy as np
from pydantic import AfterValidator, Field

from t2l.hardware.backend import Backend, BackendError
from t2l.hardware.features import Features, State
from t2l.hardware.lugre import LuGre
from t2l.hardware.motion import Motion
from t2l.hardware.virtual_physics import EFFECTS, VirtualPhysics, read, without
from t2l.hardware.virtual_signals import Noise, SetPoints
from t2l.recordings.recording import CONTINUOUS, Recording
from t2l.robots import Robot, plant
from t2l.seeds import generator
from t2l.sim.batch import diverged, make_batch
from t2l.sim.controllers.joint_pd import pd_torque
from t2l.typed import Typed, refuse

# LuGre's equation divides by it
_LEAST_FRICTION = 1e-9


def _effect(name: str) -> str:
    if name not in EFFECTS:
        raise refuse(", ".join(EFFECTS))
    return name


class Settings(Typed):
    """Whose physics, and what of it is left out."""

    physics: str | None = Field(
        None,
        min_length=1,
        description="YAML of what the MJCF does not say, for a robot of your own; one of the "
        "library's robots has its own",
    )
    without: list[Annotated[str, AfterValidator(_effect)]] = Field(
        [],
        description=f"effects that the robot is to lack, of {', '.join(EFFECTS)}",
    )


class VirtualRobot(Backend):
    """`n` virtual robots of a kind, each with gains of its own.

    Args:
        robot: what they are.
        threads: that simulate them, which change no result; by default one a core.
        physics: file of what the MJCF does not say; by default the library's for this robot.
        absent: names of effects that it lacks.

    Raises:
        ConfigurationError: there is no such file, or it lacks something.
    """

    name = "virtual"
    settings = Settings

    @classmethod
    def features(cls, robot: Robot, settings: Settings) -> Features:
        """See `Backend.features`."""
        return _features(read(robot, settings.physics))

    @classmethod
    def open(cls, robot: Robot, settings: Settings, n: int = 1) -> "VirtualRobot":
        """See `Backend.open`."""
        return cls(robot, n, threads=1, physics=settings.physics, absent=settings.without)

    @classmethod
    def truth(cls, robot: Robot, settings: Settings) -> dict[str, np.ndarray]:
        """See `Backend.truth`."""
        physics = _left(read(robot, settings.physics), settings.without)
        model = plant.load(robot.name, robot.joints).compile()
        _, dofs = _addresses(model, robot.joints)
        return {
            "armature": model.dof_armature[dofs],
            "sliding_friction": np.array(physics.coulomb),
            "breakaway": physics.coulomb * physics.breakaway_ratio,
            "viscous_friction": np.array(physics.viscous),
            "torque_scale": np.ones(len(robot.joints)),
        }

    def __init__(
        self,
        robot: Robot,
        n: int = 1,
        threads: int | None = None,
        physics: Path | str | None = None,
        absent: Iterable[str] = (),
    ):
        absent = list(absent)
        self._physics = physics = _left(read(robot, physics), absent)
        self.n, self.robot, joints = n, robot, robot.joints
        self.can = _features(physics)
        self.notes = " without ".join([f"the virtual {robot.name}", *absent])
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
            coulomb=np.maximum(physics.coulomb, _LEAST_FRICTION),
            static=np.maximum(physics.coulomb, _LEAST_FRICTION) * physics.breakaway_ratio,
            stribeck_velocity=physics.stribeck_velocity,
        )
        self._known_beforehand = False
        lag = 2 * np.pi * physics.torque_bandwidth_hz / physics.physics_rate_hz
        self._following = 1 - np.exp(-lag)
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
        self._torque, self._motor_torque = np.zeros(self._shape), np.zeros(self._shape)
        self._encoded, self._speed = self._encoders(), np.zeros(self._shape)
        self._set_points = self._latency(q)
        self._noise = Noise((2, self._shape[1]), self._generators("noise", q))
        self._measure()
        return self.read()

    def record(self, motion: Motion) -> Recording:
        """See `Backend.record`; set-points wait for no policy."""
        self._known_beforehand = True
        try:
            return super().record(motion)
        finally:
            self._known_beforehand = False

    def read(self) -> State:
        """See `Backend.read`."""
        return State(self._q.copy(), self._dq.copy(), self._torque.copy())

    def send(self, q_des: np.ndarray, period_s: float) -> None:
        """See `Backend.send`."""
        self._set_points.give(np.broadcast_to(q_des, self._shape))
        for _ in range(round(period_s * self.can.control_rate_hz)):
            self._tick(self._set_points.next())
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
        for _ in range(self._substeps):
            self._motor_torque += self._following * (self._torque - self._motor_torque)
            self._bent, friction = self._friction.advance(
                self._bent, batch.qvel[:, self._motor_v], batch.model.opt.timestep
            )
            driving = self._motor_torque + physics.torque_offset + friction
            batch.qfrc_applied[:, self._motor_v] = driving
            # gravity is compensated by the motor, and passes through the gear
            batch.qfrc_applied[:, self._twist_v] = -self._gravity[:, self._twist_v]
            batch.step()
        encoded = self._encoders()
        self._speed = self._speed + self._smoothing * (
            (encoded - self._encoded) / period - self._speed
        )
        self._encoded = encoded
        self._measure()

    def _encoders(self) -> np.ndarray:
        """Link angles (n, njoint) as encoders show them, rad."""
        q = self._batch.qpos[:, self._motor_q] + self._batch.qpos[:, self._twist_q]
        resolution = self._physics.encoder_resolution_rad
        return np.round(q / resolution) * resolution if resolution else q

    def _measure(self) -> None:
        noise = self._noise.next()
        self._q = self._encoded + self._physics.position_noise_rad * noise[:, 0]
        self._dq = self._speed + self._physics.velocity_noise_rad_s * noise[:, 1]

    def _latency(self, q: np.ndarray) -> SetPoints:
        physics, rate = self._physics, self.can.control_rate_hz
        mean, jitter = physics.policy_latency_s, physics.policy_latency_jitter_s
        if self._known_beforehand:
            mean = jitter = 0.0
        mean += physics.command_latency_s
        draws = self._generators("latency", q)
        return SetPoints(self._encoded, mean * rate, jitter * rate, draws)

    def _generators(self, what: str, q: np.ndarray) -> list[np.random.Generator]:
        """One a robot, the same for the same start q under the same gains."""
        begun = np.stack([np.broadcast_to(part, self._shape) for part in (q, self._kp, self._kd)])
        return [
            generator(0, "virtual", what, i, zlib.crc32(np.ascontiguousarray(begun[:, i])))
            for i in range(self.n)
        ]


def _features(physics: VirtualPhysics) -> Features:
    # the plant itself carries its weight, at every physics step
    return Features(physics.control_rate_hz, gravity_compensation=CONTINUOUS, truth_known=True)


def _left(physics: VirtualPhysics, absent: Iterable[str]) -> VirtualPhysics:
    for name in absent:
        physics = without(physics, name)
    return physics


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
