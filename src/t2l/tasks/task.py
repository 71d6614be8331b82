"""What every task offers to the stages that demonstrate, replay and roll out."""

from abc import ABC, abstractmethod
from functools import cached_property
from typing import TYPE_CHECKING

import mujoco
import numpy as np
from mujoco.batch import Batch

from t2l.robots import Robot
from t2l.typed import Typed

if TYPE_CHECKING:
    from t2l.tasks.waypoints import Waypoint


class Monitor(ABC):
    """Watches the simulations of one batch and says, at the end, how each went.

    Attributes:
        success_time_s: (nsim,) time at which each became a success, NaN before.
    """

    success_time_s: np.ndarray

    @abstractmethod
    def update(self, batch: Batch, time_s: float, running: np.ndarray) -> None:
        """Take in the state of the `running` simulations; called at the policy's rate."""

    @abstractmethod
    def failures(self, running: np.ndarray) -> list[str]:
        """Per simulation the kind of failure, '' for a success, 'diverged' where not `running`."""


class Task(ABC):
    """A scene with a robot in it.

    Attributes:
        name: as in paths.
        instruction: the task in words, stored with every data set.
        robot: the robot in the scene.
        parameters: what a file of config/tasks/ may hold, the arguments of the class.
        horizon_s: how long a policy has.
        observation_names: one per element of an observation: first the robot's own state,
            beginning with q and dq, then that of its environment.
        robot_observation_size: how many of them are the robot's own.
    """

    name: str
    instruction: str
    robot: Robot
    parameters: type[Typed]
    horizon_s: float
    observation_names: tuple[str, ...]
    robot_observation_size: int

    @abstractmethod
    def spec(self, visual: bool) -> mujoco.MjSpec:
        """The scene; `visual` adds what only a renderer needs."""

    @abstractmethod
    def sample_starts(self, rng: np.random.Generator, n: int) -> np.ndarray:
        """(n, nq) start positions, at rest."""

    @abstractmethod
    def observe(self, batch: Batch) -> np.ndarray:
        """(nsim, nobs) privileged state of every simulation, its derived fields current."""

    @abstractmethod
    def waypoints(self, rng: np.random.Generator, qpos: np.ndarray) -> "list[Waypoint]":
        """One way to solve the task from `qpos` (nq,), varied by `rng`, for an expert to follow."""

    @abstractmethod
    def monitor(self, nsim: int) -> Monitor:
        """A judge for `nsim` simulations, all at their start."""

    @cached_property
    def model(self) -> mujoco.MjModel:
        """The compiled scene without visuals."""
        return self.spec(visual=False).compile()

    @cached_property
    def arm_qpos(self) -> np.ndarray:
        """Indices of the arm joints in qpos; they are hinges, so the same as in qvel."""
        return np.array([self.model.joint(j).qposadr[0] for j in self.robot.joints])

    @cached_property
    def object_qpos(self) -> np.ndarray:
        """Indices in qpos of everything that is not the robot."""
        fingers = [self.model.joint(j).qposadr[0] for j in self.robot.gripper_joints]
        return np.setdiff1d(np.arange(self.model.nq), [*self.arm_qpos, *fingers])

    @cached_property
    def gripper_qpos(self) -> int:
        """Index of the first finger in qpos."""
        return int(self.model.joint(self.robot.gripper_joints[0]).qposadr[0])

    @cached_property
    def arm_ctrl(self) -> np.ndarray:
        """Indices of the arm actuators in ctrl."""
        return np.array([self.model.actuator(j).id for j in self.robot.joints])

    @cached_property
    def gripper_ctrl(self) -> np.ndarray:
        """Indices of the finger actuators in ctrl."""
        return np.array([self.model.actuator(j).id for j in self.robot.gripper_joints])

    def command(self, ctrl: np.ndarray, arm: np.ndarray, gripper: np.ndarray) -> None:
        """Write arm commands (..., 7) and gripper commands (...) into ctrl (..., nu)."""
        ctrl[..., self.arm_ctrl] = arm
        ctrl[..., self.gripper_ctrl] = np.asarray(gripper)[..., None]

    def reset(self, batch: Batch, qpos: np.ndarray) -> None:
        """Put every simulation at rest at `qpos` (nsim, nq), gripper commanded as it stands."""
        batch.reset(stage=mujoco.mjtStage.mjSTAGE_NONE.value)
        batch.warning[:] = 0
        batch.qpos = qpos
        self.command(batch.bind("ctrl"), qpos[:, self.arm_qpos], qpos[:, self.gripper_qpos])
        batch.forward(stage=mujoco.mjtStage.mjSTAGE_VEL.value)
