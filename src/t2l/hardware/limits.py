"""What must not be asked of a robot, or found of it: the one place that compares with limits."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import mujoco
import numpy as np

from t2l.errors import RecordingError
from t2l.hardware.motion import Motion
from t2l.hardware.nominal import Response, SampledLoop
from t2l.robots import Robot

# what keeps a joint within a limit that it was found beyond, or that a simulation finds it beyond
GENTLER = "a slower or smaller motion keeps it there, or gains that damp more"

# a command this close to the end of a range leaves no room to overshoot
POSITION_MARGIN_RAD = 0.05


@dataclass(frozen=True, eq=False)
class Bounds:
    """Between what a quantity of each joint, or along each axis, must lie.

    Attributes:
        names: of joints or axes.
        low, high: (len(names),) in `unit`, infinite where there is no limit.
    """

    names: Sequence[str]
    low: np.ndarray
    high: np.ndarray
    unit: str

    def outside(self, values: np.ndarray) -> np.ndarray:
        """Which of `values` (…, len(names)) lie outside; what is not a number lies nowhere."""
        return ~((values >= self.low) & (values <= self.high))

    def allowed(self, index: int) -> str:
        """The range of a joint, in words."""
        return f"{self.low[index]:.4g} to {self.high[index]:.4g}"

    def objections(self, what: str, values: np.ndarray) -> list[str]:
        """For each row of `values` (n, len(names)) the first that lies outside, or ""."""
        outside = self.outside(values)
        # asked at every tick of a loop, and of a robot that keeps its limits
        if not outside.any():
            return [""] * len(values)
        texts = []
        for row, out in zip(values, outside, strict=True):
            i = int(np.argmax(out))
            found = f"{what} {self.names[i]} {row[i]:.4g} {self.unit}"
            texts.append(f"{found}; allowed: {self.allowed(i)}" if out[i] else "")
        return texts


def position_bounds(robot: Robot, margin_rad: float = 0.0) -> Bounds:
    """The joints' ranges, narrowed at either end."""
    low, high = robot.position_limit.T
    return Bounds(robot.joints, low + margin_rad, high - margin_rad, "rad")


def velocity_bounds(robot: Robot) -> Bounds:
    """As fast as the joints may be, either way."""
    return Bounds(robot.joints, -robot.velocity_limit, robot.velocity_limit, "rad/s")


def torque_bounds(robot: Robot) -> Bounds:
    """As much as the joints may be driven by, either way."""
    return Bounds(robot.joints, -robot.torque_limit, robot.torque_limit, "N·m")


def state_objections(
    robot: Robot,
    q: np.ndarray | None = None,
    dq: np.ndarray | None = None,
    tau: np.ndarray | None = None,
) -> list[str]:
    """For each of n robots, or instants, the first joint that is beyond a limit, or "".

    Args:
        q, dq, tau: (n, njoint) measured, rad, rad/s and N·m; None of what is not. At least one is.
    """
    parts = (
        ("position of", position_bounds, q),
        ("velocity of", velocity_bounds, dq),
        ("torque of", torque_bounds, tau),
    )
    return first_of(
        *(
            bounds(robot).objections(what, values)
            for what, bounds, values in parts
            if values is not None
        )
    )


def first_of(*checks: list[str]) -> list[str]:
    """For each robot the first objection of several checks, or ""."""
    return [next(filter(None, texts), "") for texts in zip(*checks, strict=True)]


def check_motion(robot: Robot, motion: Motion, torque: np.ndarray, path: Path) -> None:
    """Whether a robot can be asked for a motion, before anything moves.

    Args:
        torque: N·m, (ncommand, njoint), what the motion itself takes, from `motion_torque`.
        path: of the configuration, for messages.

    Raises:
        RecordingError: a position, velocity or torque beyond its limit, with joint, time, value
            and limit.
    """
    q_des = motion.q_des
    within = f", {POSITION_MARGIN_RAD} rad within its range"
    for bounds, values, how, more in (
        (position_bounds(robot, POSITION_MARGIN_RAD), q_des, "", within),
        (velocity_bounds(robot), _steps(q_des) * motion.rate_hz, "", ""),
        (torque_bounds(robot), predicted_torque(motion, torque), ", as the model predicts", ""),
    ):
        if (outside := bounds.outside(values)).any():
            row, joint = np.argwhere(outside)[0]
            where = f"{motion.name}: {robot.joints[joint]} at {motion.time[row]:.2f} s"
            found = f"{values[row, joint]:.4g} {bounds.unit}{how}"
            raise RecordingError(path, where, found, f"{bounds.allowed(joint)} {bounds.unit}{more}")


def check_loop(robot: Robot, loop: SampledLoop, motion: Motion, path: Path) -> None:
    """Whether the gains of a motion damp every swing of the nominal model.

    Args:
        loop: at the start of the motion.

    Raises:
        RecordingError: they make a joint swing by itself.
    """
    if found := loop.ringing(motion.kp, motion.kd):
        i = found.joint
        raise RecordingError(
            path,
            f"{motion.name}: {robot.joints[i]}",
            f"kp {motion.kp[i]:g} and kd {motion.kd[i]:g}, under which the simulated joint rings "
            f"by itself at {found.frequency_hz:.3g} Hz, ever more",
            f"{found.allowed}; or the armature of the joint, in the robot's file, if it lacks that",
        )


def check_responses(
    robot: Robot, motions: Sequence[Motion], response: Response, path: Path
) -> None:
    """Whether motions stay within what may be measured of a robot, by the nominal model.

    Args:
        motions: those of the response.

    Raises:
        RecordingError: a simulated position, velocity or torque beyond its limit, with joint,
            time, value and limit.
    """
    parts = (
        (position_bounds(robot), response.q),
        (velocity_bounds(robot), response.dq),
        (torque_bounds(robot), response.torque),
    )
    for number, motion in enumerate(motions):
        for bounds, values in parts:
            if (outside := bounds.outside(values[number])).any():
                # the first moment says when it is stopped, the largest value what it would come to
                joint = int(np.argwhere(outside)[0][1])
                times = response.time[outside[:, joint]]
                middle = np.nan_to_num((bounds.high[joint] + bounds.low[joint]) / 2)
                worst = _farthest(values[number, :, joint], middle)
                where = f"{motion.name}: {robot.joints[joint]} from {times[0]:.2f} s on"
                found = f"up to {worst:.4g} {bounds.unit} when simulated under these gains"
                allowed = f"{bounds.allowed(joint)} {bounds.unit}; {GENTLER}"
                raise RecordingError(path, where, found, allowed)


def _farthest(values: np.ndarray, middle: float) -> float:
    """Of values (n,) the one that is farthest from the middle of its bounds, if there is any."""
    known = values[np.isfinite(values)]
    return float(known[np.argmax(np.abs(known - middle))]) if len(known) else np.nan


def motion_torque(
    robot: Robot, q_des: np.ndarray, rate_hz: float, model: mujoco.MjModel | None = None
) -> np.ndarray:
    """What moving along commands takes, by the model's inverse dynamics with its friction.

    Args:
        q_des: rad, (n, njoint), at `rate_hz`.
        model: of the robot, where it is compiled already.

    Returns:
        N·m, (n, njoint), without signs.
    """
    # central differences: commands have no noise that a filter would have to take away
    dq = np.gradient(q_des, 1 / rate_hz, axis=0)
    ddq = np.gradient(dq, 1 / rate_hz, axis=0)
    model = model or robot.spec(gravity_compensation=True).compile()
    data = mujoco.MjData(model)
    joints = [model.joint(name) for name in robot.joints]
    qpos, dofs = (np.array([getattr(j, a)[0] for j in joints]) for a in ("qposadr", "dofadr"))
    torque = np.empty_like(q_des)
    for row in range(len(q_des)):
        data.qpos[qpos], data.qvel[dofs], data.qacc[dofs] = q_des[row], dq[row], ddq[row]
        mujoco.mj_inverse(model, data)
        torque[row] = data.qfrc_inverse[dofs]
    return np.abs(torque)


def predicted_torque(motion: Motion, torque: np.ndarray) -> np.ndarray:
    """What following commands closely takes.

    The sum of what the motion itself takes and of what a held command adds the moment it is
    replaced: Kp times the step to the next. An arm that lags behind and swings may need more.

    Args:
        torque: N·m, (ncommand, njoint), from `motion_torque`.

    Returns:
        N·m, (ncommand, njoint), without signs.
    """
    return torque + motion.kp * np.abs(_steps(motion.q_des))


def _steps(q_des: np.ndarray) -> np.ndarray:
    return np.diff(q_des, axis=0, prepend=q_des[:1])
