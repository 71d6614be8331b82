"""People who steer a robot's tools through its position controller, and correct what they see.

The crossover model (McRuer and Jex 1967, "A review of quasi-linear pilot models"): near the
frequency ω_c at which its gain is one, the loop of a person and whatever is controlled is
ω_c e^(−sτ)/s, because people make up for what lags in between. Here the person intends a motion of
the tool and adds to it what is seen to be wrong,

    ẋ = ẋ_plan + ω_c e(t − τ),   e = x_plan − x_tool,

and makes up for how arm and controller answer by an inverse model of both, as people learn it
(Shadmehr and Mussa-Ivaldi 1994, "Adaptive representation of dynamics during learning of a motor
task"): it commands what gives the arm the torque M q̈ + bias, where q are the joints for x. Friction,
contacts and loads are not in it. They are seen, and corrected.

Motion is executed with noise in proportion to its speed (Harris and Wolpert 1998, "Signal-dependent
noise determines motor planning"). The plan waits at each waypoint until the tool is seen there.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import mujoco
import numpy as np
from mujoco.batch import Batch
from scipy.spatial.transform import Rotation

from t2l.actions import Control
from t2l.demos.plan import planned
from t2l.sim import make_batch
from t2l.sim.controllers.arm_dynamics import ArmDynamics
from t2l.sim.controllers.operational_space import POSE_SIZE, rotation_error
from t2l.sim.delay import DelayLine
from t2l.tasks import Demonstrated

# within which a tool counts as arrived: well within the 20 mm that fingers leave beside a block
ARRIVED_M, ARRIVED_RAD = 0.008, 0.08
# of each of the two lags by which muscles smooth noise: voluntary movements end at some 2 Hz
MUSCLE_S = 0.1
# of the least squares for the joints: bounded steps near a singular pose, 0.1 % short elsewhere
DAMPING = 1e-4


@dataclass(frozen=True)
class Person:
    """What limits an operator.

    Attributes:
        reaction_s: τ, from seeing to acting.
        motor_noise: by how much the end of a movement of one second scatters, in each direction, as
            a share of its length.
    """

    reaction_s: float
    motor_noise: float


class Operator:
    """Steers every simulation of a batch through the waypoints of its task.

    Args:
        batch: at `starts`, with the controller installed, before its first step.
        starts: (n, nq).
        tick_s: from one command to the next.
        crossover_rad_s: ω_c, (n,) or one number.

    Attributes:
        finished: (n,) bool, which have been seen to arrive at their last waypoint.
    """

    def __init__(
        self,
        task: Demonstrated,
        control: Control,
        batch: Batch,
        starts: np.ndarray,
        tick_s: float,
        person: Person,
        crossover_rad_s: np.ndarray | float,
        rng: np.random.Generator,
    ):
        n, robot = len(starts), task.robot
        self._task, self._tick_s, self._rng = task, tick_s, rng
        self._tools = [ArmDynamics(batch, arm) for arm in robot.arms]
        self._ends = np.cumsum([len(arm.joints) for arm in robot.arms])[:-1]
        self._plan = planned(task, self._tools, starts, tick_s, rng)
        self._at = np.zeros(n, int)
        self.finished = np.zeros(n, bool)
        self._crossover = np.broadcast_to(crossover_rad_s, n)
        self._controller = control.controller
        self._seen = DelayLine(np.array(person.reaction_s / tick_s))
        # white, so that its integral over a second scatters by motor_noise
        self._noise_size = person.motor_noise / np.sqrt(tick_s)
        self._noise = np.zeros((2, n, len(self._tools), 6))

        # the arm as it is meant to be
        self._meant = make_batch(task.model, n)
        self._meant.qpos[:] = starts
        self._meant_tools = [ArmDynamics(self._meant, arm) for arm in robot.arms]
        self._velocity = np.zeros((n, len(robot.joints)))
        self._pose = _poses(self._meant_tools)

    def act(self, running: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The next command (n, ncommand) and gripper command (n, ngripper).

        Args:
            running: (n,) bool; what others are sent means nothing.
        """
        wanted, now = self._planned(self._at), _poses(self._tools)
        before, seen = np.split(self._seen_poses(wanted, now), 2, axis=1)
        arrived = self._arrived(_difference(wanted, seen))
        last = self._at == self._plan.lengths - 1
        self.finished |= running & last & arrived
        self._at = self._at + (running & arrived & ~last)

        planned_change = _difference(self._planned(self._at), wanted) / self._tick_s
        correction = self._crossover[:, None, None] * _difference(before, seen)
        velocity = np.where(running[:, None, None], planned_change + correction, 0)
        self._pose = _moved(self._pose, (velocity + self._shaken(velocity)) * self._tick_s)
        return self._command(), self._plan.gripper[np.arange(len(running)), self._at]

    def _planned(self, at: np.ndarray) -> np.ndarray:
        """(n, narm, 12) poses at steps (n,) of the plan."""
        rows = np.arange(len(at))
        poses = [
            np.concatenate([m.position[rows, at], m.rotation[rows, at].reshape(-1, 9)], axis=1)
            for m in self._plan.motions
        ]
        return np.stack(poses, axis=1)

    def _seen_poses(self, *poses: np.ndarray) -> np.ndarray:
        together = np.concatenate(poses, axis=1)
        return self._seen(together.reshape(len(together), -1)).reshape(together.shape)

    def _arrived(self, missing: np.ndarray) -> np.ndarray:
        """(n,) bool, whether no arm is at a waypoint of its plan and seen elsewhere."""
        rows = np.arange(len(missing))
        stops = np.stack([m.arrived[rows, self._at] for m in self._plan.motions], axis=1)
        sizes = np.linalg.norm(missing.reshape(*stops.shape, 2, 3), axis=3)
        return (~stops | (sizes < (ARRIVED_M, ARRIVED_RAD)).all(axis=2)).all(axis=1)

    def _shaken(self, velocity: np.ndarray) -> np.ndarray:
        """The next noise of the velocity, (n, narm, 6)."""
        taken = 1 - np.exp(-self._tick_s / MUSCLE_S)
        noise = self._rng.normal(0, self._noise_size, velocity.shape)
        for lagged in self._noise:
            lagged += taken * (noise - lagged)
            noise = lagged
        parts = velocity.reshape(*velocity.shape[:2], 2, 3)
        speed = np.repeat(np.linalg.norm(parts, axis=3), 3, axis=2)
        return speed * noise

    def _command(self) -> np.ndarray:
        """That takes the arms to where they are meant to be in the coming tick."""
        q = self._meant.qpos[:, self._task.arm_qpos]
        missing = _difference(self._pose, _poses(self._meant_tools)).swapaxes(0, 1)
        change = _by_arm(_joint_step, self._meant_tools, missing)
        velocity = change / self._tick_s
        acceleration = (velocity - self._velocity) / self._tick_s
        self._velocity = velocity
        # the middle of the tick stands for all of it
        self._place(q + change / 2, velocity)
        parts = np.split(acceleration, self._ends, axis=1)
        torque = _by_arm(_torque, self._meant_tools, parts)
        command = self._controller.solved(self._meant.qpos, velocity, torque)
        self._place(q + change, velocity)
        return command

    def _place(self, q: np.ndarray, dq: np.ndarray) -> None:
        self._meant.qpos[:, self._task.arm_qpos] = q
        self._meant.qvel[:, self._task.arm_dofs] = dq
        self._meant.forward(stage=mujoco.mjtStage.mjSTAGE_VEL.value)


def _by_arm(
    function: Callable[[ArmDynamics, np.ndarray], np.ndarray],
    arms: Sequence[ArmDynamics],
    values: Sequence[np.ndarray],
) -> np.ndarray:
    """(n, njoint) of all arms, each with a value of its own."""
    return np.concatenate([function(*pair) for pair in zip(arms, values, strict=True)], axis=1)


def _joint_step(arm: ArmDynamics, change: np.ndarray) -> np.ndarray:
    """(n, njoint) for a small change of the tool's pose (n, 6)."""
    jacobian = arm.jacobian()
    square = jacobian @ jacobian.transpose(0, 2, 1) + DAMPING * np.eye(6)
    return np.einsum("nij,ni->nj", jacobian, np.linalg.solve(square, change[:, :, None])[:, :, 0])


def _torque(arm: ArmDynamics, acceleration: np.ndarray) -> np.ndarray:
    """(n, njoint) for an acceleration (n, njoint)."""
    return np.einsum("nij,nj->ni", arm.mass(), acceleration) + arm.bias()


def _poses(tools: list[ArmDynamics]) -> np.ndarray:
    """(n, narm, 12) position and rotation of each tool."""
    poses = [np.concatenate([t.position, t.rotation.reshape(-1, 9)], axis=1) for t in tools]
    return np.stack(poses, axis=1)


def _difference(there: np.ndarray, here: np.ndarray) -> np.ndarray:
    """(n, narm, 6) from poses (n, narm, 12): m and rad."""
    turned = rotation_error(*(p[:, :, 3:].reshape(-1, 3, 3) for p in (there, here)))
    offset = there[:, :, :3] - here[:, :, :3]
    return np.concatenate([offset, turned.reshape(offset.shape)], axis=2)


def _moved(pose: np.ndarray, change: np.ndarray) -> np.ndarray:
    """Poses (n, narm, 12) after small changes (n, narm, 6)."""
    turn = Rotation.from_rotvec(change[:, :, 3:].reshape(-1, 3)).as_matrix()
    rotation = turn @ pose[:, :, 3:].reshape(-1, 3, 3)
    position = pose[:, :, :3] + change[:, :, :3]
    return np.concatenate([position, rotation.reshape(*position.shape[:2], POSE_SIZE - 3)], axis=2)
