"""Operational-space control: the tool moves like a damped spring, the posture in its null space.

Khatib (1987), "A unified approach for motion and force control of robot manipulators", eq. 31-35,
for a batch of states, and its law as the study states it (its appendix on task-space retargeting):

    τ = Jᵀ w + M d + bias,   w = M_x (Kp x̃ − Kd ẋ − J d),   M_x = (J M⁻¹ Jᵀ + ε 1)⁻¹

d accelerates the joints towards the posture. The wrench w takes back what d does to the tool, so
only the null space's part of d is left. ε damps M_x near singular poses. The torques accelerate the
tool by a = J M⁻¹ (τ − bias) = J M⁻¹ Jᵀ w + J d. Solved for the command:

    x_des = x + Kp⁻¹ (a + ε w + Kd ẋ),   w = (J M⁻¹ Jᵀ)⁻¹ (a − J d)

The sum is on the rotation group for orientations, where it ends at half a turn: no pose asks for
more.
"""

from copy import copy

import mujoco
import numpy as np
from mujoco.batch import Batch
from numpy.typing import ArrayLike
from scipy.spatial.transform import Rotation

from t2l.sim.batch import apply_torque_control, make_batch, step
from t2l.sim.controllers.arm_dynamics import ArmDynamics
from t2l.sim.controllers.controller import Controller
from t2l.sim.rotations import rotation_vectors

# of the posture in the null space, 1/s²; its damping is critical
POSTURE_STIFFNESS = 60.0

# ε of damped least squares, 1/kg and 1/(kg·m²), keeps torques bounded near a singular pose; the
# tasks' demonstrations stay where J M⁻¹ Jᵀ is at least fifty times as large
DAMPING = 1e-4

# added in place of ε where the law is inverted, below rounding: a singular pose has an answer too
SOLVABLE = 1e-14

# of a command from a pose, rad: at π, either way round is the shorter one
LARGEST_TURN = 0.99 * np.pi

# numbers in a pose: position, and the rotation matrix by rows
POSE_SIZE = 12


def rotation_error(rotation_des: np.ndarray, rotation: np.ndarray) -> np.ndarray:
    """World-frame axis-angle error between (n, 3, 3) rotations, (n, 3), exact to first order.

    Half the sum of the cross products of the columns (Luh, Walker and Paul 1980, eq. 18).
    """
    return 0.5 * np.cross(rotation, rotation_des, axisa=1, axisb=1, axisc=2).sum(axis=1)


def operational_space_torque(
    q: np.ndarray,
    dq: np.ndarray,
    mass: np.ndarray,
    jacobian: np.ndarray,
    bias: np.ndarray,
    error: np.ndarray,
    twist_des: np.ndarray | float,
    acceleration_des: np.ndarray | float,
    posture: np.ndarray,
    kp: ArrayLike,
    kd: ArrayLike,
) -> np.ndarray:
    """Torques, (n, dof) N·m.

    Args:
        q, dq: (n, dof) rad and rad/s.
        mass: (n, dof, dof) joint-space inertia, kg·m².
        jacobian: (n, 6, dof), translation above rotation, world frame.
        bias: (n, dof) Coriolis torque and whatever gravity nothing else compensates, N·m.
        error: (n, 6) desired minus actual pose, m and rad.
        twist_des, acceleration_des: (n, 6) desired velocity and acceleration of the frame.
        posture: (dof,) rad, the pose that the null space drifts to.
        kp, kd: 1/s² and 1/s, one number or one an axis.
    """
    twist = np.einsum("nij,nj->ni", jacobian, dq)
    acceleration = acceleration_des + kp * error + kd * (twist_des - twist)
    drift = _drift(q, dq, posture)
    damped = _mobility(mass, jacobian) + DAMPING * np.eye(6)
    # the wrench takes back what the posture would do to the tool: the null space's projection
    missing = acceleration - np.einsum("nij,nj->ni", jacobian, drift)
    wrench = np.linalg.solve(damped, missing[:, :, None])[:, :, 0]
    return np.einsum("nji,nj->ni", jacobian, wrench) + np.einsum("nij,nj->ni", mass, drift) + bias


def operational_space_error(
    q: np.ndarray,
    dq: np.ndarray,
    mass: np.ndarray,
    jacobian: np.ndarray,
    bias: np.ndarray,
    torque: np.ndarray,
    posture: np.ndarray,
    kp: ArrayLike,
    kd: ArrayLike,
) -> np.ndarray:
    """The inverse of `operational_space_torque`, of a target at rest: errors, (n, 6) m and rad.

    Args:
        torque: (n, dof) N·m. If its null-space part is not the law's, the law yields another
            torque that accelerates the tool alike.

    The others are those of `operational_space_torque`.
    """
    twist = np.einsum("nij,nj->ni", jacobian, dq)
    moved = np.linalg.solve(mass, (torque - bias)[:, :, None])[:, :, 0]
    acceleration = np.einsum("nij,nj->ni", jacobian, moved)
    missing = acceleration - np.einsum("nij,nj->ni", jacobian, _drift(q, dq, posture))
    solvable = _mobility(mass, jacobian) + SOLVABLE * np.eye(6)
    wrench = np.linalg.solve(solvable, missing[:, :, None])[:, :, 0]
    return (acceleration + DAMPING * wrench + kd * twist) / kp


def _mobility(mass: np.ndarray, jacobian: np.ndarray) -> np.ndarray:
    """(n, 6, 6) of the tool, J M⁻¹ Jᵀ."""
    return jacobian @ np.linalg.solve(mass, jacobian.transpose(0, 2, 1))


def _drift(q: np.ndarray, dq: np.ndarray, posture: np.ndarray) -> np.ndarray:
    """(n, dof) rad/s², accelerations towards the posture."""
    return POSTURE_STIFFNESS * (posture - q) - 2 * np.sqrt(POSTURE_STIFFNESS) * dq


class OperationalSpacePD(Controller):
    """A command is the pose of each arm's tool: position in m, then a rotation matrix by rows.

    Args:
        rotation: factors `kp`, `kd` on the gains of rotation; without it those of translation.
    """

    name = "operational_space_pd"
    units = ("1/s²", "1/s")
    settings = ("rotation",)

    def __init__(self, model, arms, kp, kd, rotation=None):
        if rotation is not None:
            kp, kd = (
                gain * np.repeat([1.0, rotation[key]], 3) for gain, key in ((kp, "kp"), (kd, "kd"))
            )
        super().__init__(model, arms, kp, kd)
        elements = (*(f"{c}" for c in "xyz"), *(f"r{i}{j}" for i in "123" for j in "123"))
        self.command_names = tuple(
            f"x_des.{arm.tool_site}.{name}" for arm in arms for name in elements
        )
        self.command_units = (*("m",) * 3, *("1",) * 9) * len(arms)
        self._tools = [model.site(arm.tool_site).id for arm in arms]
        self._unforced = _without_forces(model)
        self._law: Batch | None = None
        self._dynamics: list[ArmDynamics] = []

    def install(self, batch: Batch) -> None:
        """See `Controller.install`."""
        apply_torque_control(batch, self.joints)
        for field in ("site_xpos", "site_xmat"):
            batch.bind(field)
        batch.forward(stage=mujoco.mjtStage.mjSTAGE_VEL.value)
        # of the same states, for the law alone: it is of the model, whatever a simulation has else
        self._law = make_batch(self._unforced, batch.nsim, batch.nthread)
        self._dynamics = [ArmDynamics(self._law, arm) for arm in self.arms]

    def measured(self, batch: Batch) -> np.ndarray:
        """See `Controller.measured`: the poses of the tools."""
        position, rotation = (
            batch.bind(name)[:, self._tools] for name in ("site_xpos", "site_xmat")
        )
        return np.concatenate([position, rotation], axis=2).reshape(batch.nsim, -1)

    def step(self, batch, command, running, nstep):
        """See `Controller.step`; the law is evaluated at every timestep."""
        targets = [_target(pose, running) for pose in np.split(command, len(self.arms), axis=1)]
        for left in reversed(range(nstep)):
            if not running.any():
                return
            self._law.state[:] = batch.state
            self._law.forward(ids=running, stage=mujoco.mjtStage.mjSTAGE_VEL.value)
            torque = [
                operational_space_torque(
                    q=dynamics.q,
                    dq=dynamics.dq,
                    mass=dynamics.mass(),
                    jacobian=dynamics.jacobian(),
                    bias=dynamics.bias(),
                    error=_difference(*target, dynamics),
                    twist_des=0.0,
                    acceleration_des=0.0,
                    posture=arm.posture,
                    kp=self.kp,
                    kd=self.kd,
                )
                for arm, dynamics, target in zip(self.arms, self._dynamics, targets, strict=True)
            ]
            batch.bind("ctrl")[:, self.ctrl] = np.concatenate(torque, axis=1)
            # only the last step is looked at
            stage = mujoco.mjtStage.mjSTAGE_NONE if left else mujoco.mjtStage.mjSTAGE_VEL
            step(batch, running, stage=stage)

    def commands(self, qpos, dq, torque):
        """See `Controller.commands`: the law is evaluated where a timestep begins.

        Joints of no arm, as a gripper's, act on the arm's bias too. How fast they are follows from
        where they were a timestep before, exactly, as velocities are integrated (semi-implicitly).
        """
        model = self.model
        scalar = np.isin(model.jnt_type, (mujoco.mjtJoint.mjJNT_HINGE, mujoco.mjtJoint.mjJNT_SLIDE))
        positions = qpos[:, model.jnt_qposadr[scalar]]
        qvel = np.zeros((len(qpos), model.nv))
        qvel[1:, model.jnt_dofadr[scalar]] = np.diff(positions, axis=0) / model.opt.timestep
        qvel[:, self.dofs] = dq
        return self._solved(qpos[:-1], qvel[:-1], torque[:-1])

    def solved(self, qpos, dq, torque):
        """See `Controller.solved`."""
        qvel = np.zeros((len(qpos), self.model.nv))
        qvel[:, self.dofs] = dq
        return self._solved(qpos, qvel, torque)

    def _solved(self, qpos: np.ndarray, qvel: np.ndarray, torque: np.ndarray) -> np.ndarray:
        """`solved`, with the velocities (n, nv) of everything in the scene."""
        n = len(qpos)
        batch = make_batch(self._unforced, n)
        batch.qpos[:] = qpos
        batch.qvel[:] = qvel
        parts, first = [], 0
        for arm in self.arms:
            dynamics = ArmDynamics(batch, arm)
            own = slice(first, first + len(arm.joints))
            first = own.stop
            error = operational_space_error(
                q=dynamics.q,
                dq=dynamics.dq,
                mass=dynamics.mass(),
                jacobian=dynamics.jacobian(),
                bias=dynamics.bias(),
                torque=torque[:, own],
                posture=arm.posture,
                kp=self.kp,
                kd=self.kd,
            )
            turn = Rotation.from_rotvec(_at_most_half(error[:, 3:])).as_matrix()
            rotation = turn @ dynamics.rotation
            parts += [dynamics.position + error[:, :3], rotation.reshape(n, 9)]
        return np.concatenate(parts, axis=1)

    def mean(self, commands, starts):
        """See `Controller.mean`: rotations by their chordal mean."""
        mean = super().mean(commands, starts)
        poses = mean.reshape(len(starts), len(self.arms), POSE_SIZE)
        rotation = poses[:, :, 3:].reshape(-1, 3, 3)
        poses[:, :, 3:] = Rotation.from_matrix(rotation).as_matrix().reshape(*poses.shape[:2], 9)
        return poses.reshape(len(starts), -1)


def _without_forces(model: mujoco.MjModel) -> mujoco.MjModel:
    """The same model, which computes no contacts, constraints, sensors or actuators.

    Nothing of what the law reads depends on them, and they take half of the time.
    """
    other = copy(model)
    for part in ("CONTACT", "CONSTRAINT", "SENSOR", "ACTUATION"):
        other.opt.disableflags |= getattr(mujoco.mjtDisableBit, f"mjDSBL_{part}").value
    return other


def _at_most_half(turn: np.ndarray) -> np.ndarray:
    """Rotation vectors (n, 3) rad, cut at `LARGEST_TURN`: more would pull the other way."""
    angle = np.linalg.norm(turn, axis=1, keepdims=True)
    return turn * (LARGEST_TURN / np.maximum(angle, LARGEST_TURN))


def _target(pose: np.ndarray, running: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(n, 3) positions of poses (n, 12), and the rotations (n, 3, 3) that are closest to theirs."""
    # what no longer runs may hold no rotation at all
    rotation = np.where(running[:, None, None], pose[:, 3:].reshape(-1, 3, 3), np.eye(3))
    return pose[:, :3], Rotation.from_matrix(rotation).as_matrix()


def _difference(position: np.ndarray, rotation: np.ndarray, now: ArmDynamics) -> np.ndarray:
    """(n, 6) from where an arm is: position, and the world-frame rotation vector, m and rad."""
    turn = rotation_vectors(rotation @ now.rotation.transpose(0, 2, 1))
    return np.concatenate([position - now.position, turn], axis=1)
