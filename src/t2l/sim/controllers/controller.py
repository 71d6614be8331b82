"""What every controller does: a command held from the policy, torques at each of its own ticks."""

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import ClassVar

import mujoco
import numpy as np
from mujoco.batch import Batch


@dataclass(frozen=True)
class Arm:
    """Joints in a row and the tool they move, as a model names them.

    Attributes:
        joints: with an actuator of the same name each.
        tool_site: that task space is about.
        posture: (njoint,) rad, which a null space drifts to.
    """

    joints: tuple[str, ...]
    tool_site: str
    posture: np.ndarray


class Controller(ABC):
    """Turns commands into joint torques, for a batch of simulations of one model.

    The same law, solved for its command, retargets demonstrations: `solved`, `commands`.

    Args:
        model: with the arms in it.
        arms: that are controlled; a command holds one after another.
        kp, kd: gains, one number each or one a joint (or axis); the units are the controller's.

    Attributes:
        name: what configurations write.
        units: of stiffness and damping.
        settings: other keywords that it takes, from the `actions` section of a configuration.
        command_names, command_units: of the elements of a command.
    """

    name: ClassVar[str]
    units: ClassVar[tuple[str, str]]
    settings: ClassVar[tuple[str, ...]] = ()
    command_names: tuple[str, ...]
    command_units: tuple[str, ...]

    def __init__(self, model: mujoco.MjModel, arms: tuple[Arm, ...], kp, kd):
        self.model, self.arms, self.kp, self.kd = model, arms, kp, kd
        self.joints = tuple(joint for arm in arms for joint in arm.joints)
        self.qpos = np.array([model.joint(name).qposadr[0] for name in self.joints])
        self.dofs = np.array([model.joint(name).dofadr[0] for name in self.joints])
        self.ctrl = np.array([model.actuator(name).id for name in self.joints])

    @abstractmethod
    def install(self, batch: Batch) -> None:
        """Make the joints' actuators take what `step` writes."""

    @abstractmethod
    def measured(self, batch: Batch) -> np.ndarray:
        """(nsim, ncommand) what commands are about, as it is now."""

    @abstractmethod
    def step(self, batch: Batch, command: np.ndarray, running: np.ndarray, nstep: int) -> None:
        """Hold a command (nsim, ncommand) for `nstep` timesteps; see `t2l.sim.batch.step`."""

    @abstractmethod
    def solved(self, qpos: np.ndarray, dq: np.ndarray, torque: np.ndarray) -> np.ndarray:
        """(n, ncommand) at which the law yields torques (n, njoint) in each of n states.

        Args:
            qpos: (n, nq) of the scene.
            dq: (n, njoint) rad/s.
            torque: (n, njoint) N·m, net of gravity compensation.
        """

    @abstractmethod
    def commands(self, qpos: np.ndarray, dq: np.ndarray, torque: np.ndarray) -> np.ndarray:
        """(n - 1, ncommand) at which the law yields a recorded run's torques.

        Args:
            qpos: (n, nq) of the scene at each timestep.
            dq: (n, njoint) rad/s.
            torque: (n, njoint) N·m over the timestep that follows, net of gravity compensation.
        """

    def mean(self, commands: np.ndarray, starts: np.ndarray) -> np.ndarray:
        """(nstart, ncommand) means of the commands from each of `starts` to the next."""
        lengths = np.diff([*starts, len(commands)])
        return np.add.reduceat(commands, starts, axis=0) / lengths[:, None]
