"""People who steer a robot's tools through its position controller, and correct what they see.

The crossover model (McRuer and Jex 1967, "A review of quasi-linear pilot models"): near the
frequency ω_c at which its gain is one, the loop of a person and whatever is controlled is
ω_c e^(−sτ)/s, because people make up for what lags in between. Here the person intends a motion of
the tool and adds to it what is seen to be wrong,

    ẋ = ẋ_plan + ω_c e(t − τ),   e = x_plan − x_tool,

and makes up for how arm and controller answer by an inverse model of both, as people learn it
(Shadmehr and Mussa-Ivaldi 1994, "Adaptive representation of dynamics during learning of a motor
task"): the command is the one at which the controller yields M q̈ + bias, where q are the joints for
x. Friction, contacts and loads are not in it. They are seen, and corrected.

Motion is executed with noise in proportion to its speed (Harris and Wolpert 1998, "Signal-dependent
noise determines motor planning"). The plan is made from where things are at the start. It waits at
each waypoint until the tool is seen there.
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
    """What an operator can do.

    Attributes:
        reaction_s: τ, from seeing to acting.
        motor_noise: by how much the end of a movement of one second scatters, in each direction, as
            a share of its length.
        crossover_rad_s: the ω_c that are tried in practice.
        practice: attempts with each of them.
    """

    reaction_s: float
    motor_noise: float
    crossover_rad_s: Sequence[float]
    practice: int


class Operator:
    """Steers every simulation of a batch through the waypoints of its task.

    Args:
        batch: at `starts`, with the controller installed, before its first step.
        starts: (n, nq).
        tick_s: from one command to the next.
        crossover_rad_s: ω_c of each, (n,), or of all.

    Attributes:
        wanted: (n, narm, 12) where the plan has the tools: position in m, rotation by rows.
        meant: (n, narm, 12) where the operator means them to be, corrections and noise included.
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
        self._task, self._controller = task, control.controller
        self._tick_s, self._rng = tick_s, rng
        self._tools = [ArmDynamics(batch, arm) for arm in robot.arms]
        self._plan = planned(task, self._tools, starts, tick_s, rng)
        self._at = np.zeros(n, int)
        self._crossover = np.broadcast_to(crossover_rad_s, n)[:, None, None]
        self._seen = DelayLine(np.array(person.reaction_s / tick_s))
        # white, so that its integral over a second scatters by motor_noise
        self._noise_size = person.motor_noise / np.sqrt(tick_s)
        self._noise = np.zeros((2, n, len(self._tools), 6))

        # the arms as they are meant to be
        self._model = make_batch(task.model, n)
        self._model.qpos[:] = starts
        self._model_tools = [ArmDynamics(self._model, arm) for arm in robot.arms]
        self._ends = np.cumsum([len(arm.joints) for arm in robot.arms])[:-1]
        self._dq = np.zeros((n, len(robot.joints)))

        self.wanted, self.meant = self._planned(self._at), _poses(self._model_tools)
        self.finished = np.zeros(n, bool)

    def act(self, running: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The next command (n, ncommand) and gripper command (n, ngripper).

        Args:
            running: (n,) bool; what others are sent means nothing.
        """
        both = np.concatenate([self.wanted, _poses(self._tools)], axis=1)
        was_wanted, seen = np.split(self._delayed(both), 2, axis=1)
        arrived = self._arrived(_difference(self.wanted, seen))
        last = self._at == self._plan.lengths - 1
        self.finished |= running & last & arrived
        self._at = self._at + (running & arrived & ~last)

        wanted = self._planned(self._at)
        planned_velocity = _difference(wanted, self.wanted) / self._tick_s
        velocity = planned_velocity + self._crossover * _difference(was_wanted, seen)
        # those that have ended may be anywhere
        velocity = np.where(running[:, None, None], velocity, 0)
        self.wanted = wanted
        self.meant = _moved(self.meant, (velocity + self._shaken(velocity)) * self._tick_s)
        return self._command(), self._plan.gripper[np.arange(len(running)), self._at]

    def _planned(self, at: np.ndarray) -> np.ndarray:
        """(n, narm, 12) poses at steps (n,) of the plan."""
        rows = np.arange(len(at))
        poses = [
            np.concatenate([m.position[rows, at], m.rotation[rows, at].reshape(-1, 9)], axis=1)
            for m in self._plan.motions
        ]
        return np.stack(poses, axis=1)

    def _delayed(self, poses: np.ndarray) -> np.ndarray:
        return self._seen(poses.reshape(len(poses), -1)).reshape(poses.shape)

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
        """That takes the arms to where they are meant to be at the end of the coming tick."""
        q = self._model.qpos[:, self._task.arm_qpos]
        missing = _difference(self.meant, _poses(self._model_tools)).swapaxes(0, 1)
        change = _by_arm(_joint_step, self._model_tools, missing)
        dq = change / self._tick_s
        ddq = np.split((dq - self._dq) / self._tick_s, self._ends, axis=1)
        self._dq = dq
        # the middle of the tick stands for all of it
        self._place(q + change / 2, dq)
        torque = _by_arm(_torque, self._model_tools, ddq)
        command = self._controller.solved(self._model.qpos, dq, torque)
        self._place(q + change, dq)
        return command

    def _place(self, q: np.ndarray, dq: np.ndarray) -> None:
        self._model.qpos[:, self._task.arm_qpos] = q
        self._model.qvel[:, self._task.arm_dofs] = dq
        self._model.forward(stage=mujoco.mjtStage.mjSTAGE_VEL.value)


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
