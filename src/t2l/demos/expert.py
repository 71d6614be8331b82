"""An expert that follows a task's waypoints under operational-space control, in torques."""

import numpy as np
from mujoco.batch import Batch

from t2l.demos.demonstration import Demonstration
from t2l.demos.plan import planned
from t2l.environment.episodes import Episodes
from t2l.errors import ExpertError
from t2l.sim import apply_torque_control, step
from t2l.sim.batch import TIMESTEP_S
from t2l.sim.controllers import Arm
from t2l.sim.controllers.arm_dynamics import ArmDynamics
from t2l.sim.controllers.operational_space import operational_space_torque, rotation_error
from t2l.tasks import Demonstrated
from t2l.tasks.waypoints import Motion

# of the tool, 1/s²; its damping is critical: a time constant of 33 ms follows motions of 0.5 s
STIFFNESS = 900.0
ATTEMPTS_AT_ONCE = 128


def demonstrate(
    task: Demonstrated, count: int, max_attempts: int, rng: np.random.Generator, threads: int = 1
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
    task: Demonstrated, starts: np.ndarray, rng: np.random.Generator, threads: int = 1
) -> tuple[list[Demonstration], np.ndarray]:
    """One demonstration from each of `starts` (n, nq), and which succeeded, (n,) bool."""
    n, robot = len(starts), task.robot
    episodes = Episodes(task, _Torques(task), starts, 1, threads)
    batch = episodes.batch
    arms = [ArmDynamics(batch, arm) for arm in robot.arms]
    plan = planned(task, arms, starts, TIMESTEP_S, rng)
    motion, gripper, lengths = plan.motions, plan.gripper, plan.lengths
    steps = gripper.shape[1]

    limit = robot.torque_limit
    qpos = np.empty((n, steps, task.model.nq))
    dq = np.empty((n, steps, limit.size))
    torque = np.empty_like(dq)
    for k in range(steps):
        qpos[:, k] = batch.qpos
        dq[:, k] = batch.qvel[:, task.arm_dofs]
        wanted = [
            _torque(arm, each, of_arm, k)
            for arm, each, of_arm in zip(robot.arms, arms, motion, strict=True)
        ]
        torque[:, k] = np.clip(np.concatenate(wanted, axis=1), -limit, limit)
        episodes.hold(torque[:, k], gripper[:, k])
        # what happens after a motion has ended is no part of its demonstration
        episodes.judge(episodes.sound & (k < lengths))
    demonstrations = [
        Demonstration(qpos[i, :m], dq[i, :m], torque[i, :m], gripper[i, :m])
        for i, m in enumerate(lengths)
    ]
    return demonstrations, episodes.sound & (episodes.success_time_s <= lengths * TIMESTEP_S)


class _Torques:
    """Commands are the joints' torques, (n, njoint) N·m."""

    def __init__(self, task: Demonstrated):
        self._task = task

    def install(self, batch: Batch) -> None:
        apply_torque_control(batch, self._task.robot.joints)

    def step(self, batch: Batch, command: np.ndarray, running: np.ndarray, nstep: int) -> None:
        batch.ctrl[:, self._task.arm_ctrl] = command
        step(batch, running, nstep)


def _torque(arm: Arm, now: ArmDynamics, motion: Motion, k: int) -> np.ndarray:
    """(n, njoint) torques that follow step k of a stacked motion."""
    error = [
        motion.position[:, k] - now.position,
        rotation_error(motion.rotation[:, k], now.rotation),
    ]
    return operational_space_torque(
        q=now.q,
        dq=now.dq,
        mass=now.mass(),
        jacobian=now.jacobian(),
        bias=now.bias(),
        error=np.concatenate(error, axis=1),
        twist_des=motion.twist[:, k],
        acceleration_des=motion.acceleration[:, k],
        posture=arm.posture,
        kp=STIFFNESS,
        kd=2 * np.sqrt(STIFFNESS),
    )
