"""An expert that follows a task's waypoints under operational-space control, in torques."""

import mujoco
import numpy as np
from mujoco.batch import Batch
from scipy.spatial.transform import Rotation

from t2l.demos.demonstration import Demonstration
from t2l.errors import ExpertError
from t2l.sim import apply_torque_control, make_batch, step
from t2l.sim.batch import TIMESTEP_S
from t2l.sim.controllers.operational_space import (
    OperationalSpaceGains,
    operational_space_torque,
    rotation_error,
)
from t2l.tasks import Task
from t2l.tasks.waypoints import Motion, Waypoint, motion_through, padded

GAINS = OperationalSpaceGains()
ATTEMPTS_AT_ONCE = 128


def demonstrate(
    task: Task, count: int, max_attempts: int, rng: np.random.Generator, threads: int = 1
) -> list[Demonstration]:
    """The first `count` successful demonstrations from random starts.

    Raises:
        ExpertError: fewer than `count` of `max_attempts` attempts succeeded.
    """
    successes: list[Demonstration] = []
    attempts = 0
    while len(successes) < count and attempts < max_attempts:
        n = min(count - len(successes), max_attempts - attempts, ATTEMPTS_AT_ONCE)
        starts = task.sample_starts(rng, n)
        demonstrations, success = attempt(task, starts, rng, threads)
        successes += [d for d, good in zip(demonstrations, success, strict=True) if good]
        attempts += n
    if len(successes) < count:
        raise ExpertError(
            f"{task.name}: the expert succeeded in {len(successes)} of {attempts} attempts "
            f"({100 * len(successes) / attempts:.0f} %), {count} successes are wanted. Raise "
            "demonstrations.max_attempts, or make the task easier in config/tasks/."
        )
    return successes


def attempt(
    task: Task, starts: np.ndarray, rng: np.random.Generator, threads: int = 1
) -> tuple[list[Demonstration], np.ndarray]:
    """One demonstration from each of `starts` (n, nq), and which succeeded, (n,) bool."""
    n = len(starts)
    batch = make_batch(task.model, n, threads)
    apply_torque_control(batch, task.robot.joints)
    task.reset(batch, starts)
    arm = _Arm(task, batch)
    motions = [
        motion_through(start, task.waypoints(rng, qpos), TIMESTEP_S)
        for start, qpos in zip(arm.grip_waypoints(), starts, strict=True)
    ]
    lengths = np.array([len(motion.gripper) for motion in motions])
    steps = int(lengths.max())
    motion = _stack([padded(motion, steps) for motion in motions])

    limit = np.asarray(task.robot.torque_limit)
    qpos = np.empty((n, steps, task.model.nq))
    dq = np.empty((n, steps, limit.size))
    torque = np.empty_like(dq)
    monitor = task.monitor(n)
    running = np.ones(n, dtype=bool)
    for k in range(steps):
        qpos[:, k] = batch.qpos
        dq[:, k] = arm.dq
        torque[:, k] = np.clip(arm.torque(motion, k), -limit, limit)
        task.command(batch.ctrl, torque[:, k], motion.gripper[:, k])
        step(batch, running, stage=mujoco.mjtStage.mjSTAGE_VEL)
        # what happens after a motion has ended is no part of its demonstration
        monitor.update(batch, (k + 1) * TIMESTEP_S, running & (k < lengths))
    demonstrations = [
        Demonstration(qpos[i, :m], dq[i, :m], torque[i, :m], motion.gripper[i, :m])
        for i, m in enumerate(lengths)
    ]
    return demonstrations, running & (monitor.success_time_s <= lengths * TIMESTEP_S)


class _Arm:
    """The arm's part of a batch's dynamics, as the controller needs it."""

    def __init__(self, task: Task, batch: Batch):
        self._task, self._batch = task, batch
        self._site = task.model.site(task.robot.grip_site)
        model, dofs = task.model, task.arm_qpos
        rows = np.repeat(np.arange(model.nv), model.M_rownnz)
        in_arm = np.isin(rows, dofs) & np.isin(model.M_colind, dofs)
        self._entries = np.flatnonzero(in_arm)
        self._rows = np.searchsorted(dofs, rows[in_arm])
        self._columns = np.searchsorted(dofs, model.M_colind[in_arm])
        # bound before the first step so that every call refreshes them
        for field in ("M", "qfrc_bias", "qfrc_gravcomp", "site_xpos", "site_xmat"):
            batch.bind(field)
        batch.forward(stage=mujoco.mjtStage.mjSTAGE_VEL.value)

    @property
    def q(self) -> np.ndarray:
        return self._batch.qpos[:, self._task.arm_qpos]

    @property
    def dq(self) -> np.ndarray:
        return self._batch.qvel[:, self._task.arm_qpos]

    @property
    def position(self) -> np.ndarray:
        return self._batch.site_xpos[:, self._site.id]

    @property
    def rotation(self) -> np.ndarray:
        return self._batch.site_xmat[:, self._site.id].reshape(-1, 3, 3)

    def grip_waypoints(self) -> list[Waypoint]:
        """Where each simulation's grip frame is now."""
        poses = zip(self.position.copy(), self.rotation.copy(), strict=True)
        return [Waypoint(p, Rotation.from_matrix(r), 0.0, 0.0) for p, r in poses]

    def mass(self) -> np.ndarray:
        """(n, dof, dof) joint-space inertia."""
        values = self._batch.M[:, self._entries]
        mass = np.zeros((self._batch.nsim, self._task.arm_qpos.size, self._task.arm_qpos.size))
        mass[:, self._rows, self._columns] = values
        mass[:, self._columns, self._rows] = values
        return mass

    def torque(self, motion: Motion, k: int) -> np.ndarray:
        """(n, dof) torques that follow step k of a stacked motion."""
        arm = self._task.arm_qpos
        linear, angular = self._batch.jac(int(self._site.bodyid[0]), self.position)
        return operational_space_torque(
            q=self.q,
            dq=self.dq,
            mass=self.mass(),
            jacobian=np.concatenate([linear, angular], axis=1)[:, :, arm],
            bias=(self._batch.qfrc_bias - self._batch.qfrc_gravcomp)[:, arm],
            position_error=motion.position[:, k] - self.position,
            rotation_error=rotation_error(motion.rotation[:, k], self.rotation),
            twist_des=motion.twist[:, k],
            acceleration_des=motion.acceleration[:, k],
            posture=np.asarray(self._task.robot.home),
            gains=GAINS,
        )


def _stack(motions: list[Motion]) -> Motion:
    fields = Motion.__dataclass_fields__
    return Motion(**{field: np.stack([getattr(m, field) for m in motions]) for field in fields})
