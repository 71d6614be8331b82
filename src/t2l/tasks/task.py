"""A task: a scene, its starts, what a policy sees of it, and when it is solved.

A task that is to be demonstrated says how (`Demonstrated`); one that is to be learned by
reinforcement says what it pays (`Rewarded`).
"""

from abc import ABC, abstractmethod
from collections.abc import Mapping
from copy import copy
from functools import cached_property
from typing import TYPE_CHECKING, Any, Self

import mujoco
import numpy as np
from mujoco.batch import Batch
from numpy.typing import ArrayLike

from t2l.errors import ConfigurationError
from t2l.robots import Robot
from t2l.robots.robot import Gripper
from t2l.sim.arrays import Array, columns, like, namespace
from t2l.tasks.terms import Moment, ObservationTerm, RewardTerm, TerminationTerm
from t2l.typed import Typed

if TYPE_CHECKING:
    from t2l.tasks.disturbance import Disturbance
    from t2l.tasks.waypoints import Waypoint

# tasks of which `Rewarded.beyond_joints` says nothing, in words
OF_JOINTS = (
    "a task of joints alone that nothing pushes and whose episodes only their length ends, such as "
    "joint_reach"
)


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
        name: of the kind, as in files of config/tasks/.
        instruction: the task in words, stored with every data set.
        parameters: what a file of config/tasks/ may hold, the arguments of the class.
        robot: the robot in the scene.
        observation_names: one per element of an observation: first the robot's own state,
            beginning with q and dq, then that of its environment.
        robot_observation_size: how many of them are the robot's own.
    """

    name: str
    instruction: str
    parameters: type[Typed]
    robot: Robot
    observation_names: tuple[str, ...]
    robot_observation_size: int

    @abstractmethod
    def spec(self, visual: bool) -> mujoco.MjSpec:
        """The scene; `visual` adds what only a renderer needs."""

    @abstractmethod
    def sample_starts(self, rng: np.random.Generator, n: int) -> np.ndarray:
        """(n, nq) start positions, at rest."""

    @cached_property
    def model(self) -> mujoco.MjModel:
        """The compiled scene without visuals."""
        return self.spec(visual=False).compile()

    @cached_property
    def cameras(self) -> tuple[str, ...]:
        """Names of the cameras of the scene with visuals."""
        return tuple(camera.name for camera in self.spec(visual=True).cameras if camera.name)

    @cached_property
    def arm_qpos(self) -> np.ndarray:
        """(njoint,) indices of the robot's joints in qpos."""
        return np.array([self.model.joint(j).qposadr[0] for j in self.robot.joints])

    @cached_property
    def arm_dofs(self) -> np.ndarray:
        """(njoint,) indices of the robot's joints in qvel."""
        return np.array([self.model.joint(j).dofadr[0] for j in self.robot.joints])

    @cached_property
    def gripper_qpos(self) -> np.ndarray:
        """Indices in qpos of every gripper's joints, one gripper after another."""
        names = [joint for gripper in self.robot.grippers for joint in gripper.joints]
        return np.array([self.model.joint(j).qposadr[0] for j in names], int)

    @cached_property
    def opening_qpos(self) -> np.ndarray:
        """(ngripper,) indices in qpos of the joints that tell how far the grippers are."""
        names = [gripper.joints[0] for gripper in self.robot.grippers]
        return np.array([self.model.joint(j).qposadr[0] for j in names], int)

    @cached_property
    def object_qpos(self) -> np.ndarray:
        """Indices in qpos of everything that is not the robot."""
        return np.setdiff1d(np.arange(self.model.nq), [*self.arm_qpos, *self.gripper_qpos])

    @cached_property
    def tool_sites(self) -> np.ndarray:
        """(ngroup,) ids of the groups' tool sites."""
        return np.array([self.model.site(group.tool_site).id for group in self.robot.groups])

    @cached_property
    def arm_ctrl(self) -> np.ndarray:
        """(njoint,) indices of the joints' actuators in ctrl."""
        return np.array([self.model.actuator(j).id for j in self.robot.joints])

    @cached_property
    def _gripper_ctrl(self) -> list[np.ndarray | slice]:
        return [
            columns(np.array([self.model.actuator(name).id for name in gripper.actuators]))
            for gripper in self.robot.grippers
        ]

    def command_grippers(self, ctrl: Array, command: Array) -> None:
        """Write gripper commands, which broadcast to (..., ngripper), into ctrl (..., nu)."""
        shape = (*ctrl.shape[:-1], len(self._gripper_ctrl))
        command = namespace(ctrl).broadcast_to(like(command, ctrl), shape)
        for i, actuators in enumerate(self._gripper_ctrl):
            ctrl[..., actuators] = command[..., i, None]

    def command(self, ctrl: np.ndarray, arm: ArrayLike, gripper: ArrayLike) -> None:
        """Write joint commands (..., njoint) and gripper commands into ctrl (..., nu)."""
        ctrl[..., self.arm_ctrl] = arm
        self.command_grippers(ctrl, gripper)

    @cached_property
    def opened(self) -> np.ndarray:
        """(ngripper,) the command that opens each gripper."""
        return np.array([gripper.opened for gripper in self.robot.grippers])

    def reset(self, batch: Batch, qpos: np.ndarray) -> None:
        """Put every simulation at rest at `qpos` (nsim, nq), hands commanded to be open."""
        batch.reset(stage=mujoco.mjtStage.mjSTAGE_NONE.value)
        batch.warning[:] = 0
        batch.qpos = qpos
        self.command(batch.bind("ctrl"), qpos[:, self.arm_qpos], self.opened)
        batch.forward(stage=mujoco.mjtStage.mjSTAGE_VEL.value)


class Demonstrated(Task):
    """A task that an expert can show.

    Attributes:
        horizon_s: how long a policy has.
    """

    horizon_s: float

    def reset(self, batch: Batch, qpos: np.ndarray) -> None:
        """As `Task.reset`; what is observed is current from then on."""
        # a batch fills a derived field only after it has been asked for once
        self.observe(batch)
        super().reset(batch, qpos)

    @abstractmethod
    def observe(self, batch: Batch) -> np.ndarray:
        """(nsim, nobs) privileged state of every simulation, its derived fields current."""

    @abstractmethod
    def waypoints(self, rng: np.random.Generator, qpos: np.ndarray) -> "list[list[Waypoint]]":
        """One way to solve the task from `qpos` (nq,), varied by `rng`: by group, for each tool."""

    @abstractmethod
    def monitor(self, nsim: int) -> Monitor:
        """A judge for `nsim` simulations, all at their start."""


class Rewarded(Task):
    """A task that is learned by trying: it pays at every step, and is judged at an episode's end.

    What a policy sees, what is paid and what ends an episode are terms, see `t2l.tasks.terms`. The
    policy sees its last action too, whatever the terms.

    Attributes:
        goal_size: numbers in a goal.
        observations: what a policy sees, first q and q̇.
        rewards: what is paid.
        terminations: what ends an episode before its time, as a failure.
        tuned: names of the weights that tuning may change.
        steady: whether a success must be without jitter, see `t2l.environment.limits`.
        closed_hand: whether grippers are closed all the time, and no action commands them.
        least_rate_hz: of the physics, at which its contacts hold.
        on_gpu: whether its methods take torch's arrays too, and need no more of a batch than
            `t2l.sim.warp_batch.WarpBatch` has.
        hyperparameters: of the algorithm, a column of the study's table, see
            `t2l.rl.hyperparameters`.
    """

    goal_size: int
    observations: tuple[ObservationTerm, ...]
    rewards: tuple[RewardTerm, ...]
    terminations: tuple[TerminationTerm, ...] = ()
    tuned: tuple[str, ...] = ()
    steady = True
    closed_hand = False
    least_rate_hz = 0.0
    on_gpu = False
    hyperparameters = "reach"

    @abstractmethod
    def sample_goals(self, rng: np.random.Generator, n: int) -> np.ndarray:
        """(n, goal_size), all reachable."""

    @abstractmethod
    def measure(self, batch: Batch, goal: np.ndarray) -> Any:
        """What terms need of the simulations besides their state, made once a step.

        Arrays with a row a simulation, of the task's own choice; no views of the batch, which goes
        on. What needs derived fields calls `batch.forward` first.
        """

    def follow(self, now: Any, before: Any, elapsed_s: float, began: np.ndarray) -> Any:
        """What was measured, with what it carries on from the moment before: nothing, unless said.

        Args:
            now: what `measure` made.
            before: what this made of the moment before; None at the beginning of all.
            elapsed_s: since then.
            began: (k,) which robots begin an episode: they have nothing before.
        """
        return now

    @abstractmethod
    def success(self, at: Moment) -> np.ndarray:
        """(n,) bool."""

    def disturbance(self, batch: Batch, generator: np.random.Generator) -> "Disturbance | None":
        """What acts on the robots of a batch while they learn; nothing, unless a task says so."""
        return None

    @property
    def observation_names(self) -> tuple[str, ...]:
        """See `Task`."""
        return tuple(name for term in self.observations for name in term.names)

    @cached_property
    def weights(self) -> Mapping[str, float]:
        """Of the reward's terms, by name, and what other numbers a task lets one change."""
        return {term.name: term.weight for term in self.rewards}

    @property
    def commanded_grippers(self) -> tuple[Gripper, ...]:
        """Those that actions have elements for."""
        return () if self.closed_hand else self.robot.grippers

    def observe(self, at: Moment) -> np.ndarray:
        """(n, nobs) what a policy sees of a moment."""
        xp = namespace(at.q)
        return xp.concat([term.value(at) for term in self.observations], axis=1)

    def paid(self, at: Moment) -> list[np.ndarray]:
        """What a step is worth term by term, (n,) each; the reward is their sum.

        It is weight · value · period: a weight is of a second, as those of IsaacLab and mjlab are
        (`RewardManager.compute`), so that a return does not depend on how often the policy acts.
        """
        return [
            at.period_s * (self.weights[term.name] * term.factor(at.steps) * term.value(at))
            for term in self.rewards
        ]

    @property
    def deployable(self) -> bool:
        """Whether a robot can do it by its joints alone: nothing to grasp, nothing else to see."""
        return not (self.gripper_qpos.size or self.object_qpos.size)

    @property
    def beyond_joints(self) -> str:
        """What of it a model of the joints alone cannot show, in words; nothing if it shows all."""
        if not self.deployable:
            return "objects or a hand, which a model of the joints cannot move"
        if type(self).disturbance is not Rewarded.disturbance:
            return "forces from outside, which a model of the joints does not feel"
        if self.terminations:
            names = ", ".join(term.name for term in self.terminations)
            return f"episodes that may end early ({names}), which leaves unequal motions to compare"
        return ""

    def reweighted(self, weights: Mapping[str, float]) -> Self:
        """The task with some weights of its reward replaced.

        Raises:
            ConfigurationError: the reward has no such weight.
        """
        unknown = [weight for weight in weights if weight not in self.weights]
        if unknown:
            raise ConfigurationError(
                f"reward weights of {self.name}: found {', '.join(unknown)}; allowed: "
                f"{', '.join(self.weights)}"
            )
        other = copy(self)
        other.weights = {**self.weights, **weights}
        return other
