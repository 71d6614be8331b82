"""What a robot is shown to do: joint motions with their torques, at the rate they were recorded.

Of demonstrations of a task the expert's torques are known. A LeRobot data set of joint positions
tells them by its commands if its gains are known; else they are those of a free motion, by inverse
dynamics, and what contacts asked for is missing.
"""

import copy
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import mujoco
import numpy as np

from t2l.demos.demonstration import Demonstration
from t2l.demos.other_gains import Gains, check_positions
from t2l.errors import RecordingError
from t2l.recordings.importers.lerobot_dataset import (
    ACTION,
    STATE,
    feature_of,
    names_of,
    read_episodes,
    read_info,
)
from t2l.sim.batch import TIMESTEP_S
from t2l.sim.controllers.joint_pd import pd_torque
from t2l.tasks import Demonstrated

ENVIRONMENT = "observation.environment_state"
FEWEST = 2  # statistics: what one does is compared with another
LEAST_S = 0.2  # bound: a shorter motion says nothing
# how data sets call a joint's command, position, velocity and torque
COMMAND, TORQUE = ("{}", "{}.pos", "q_des.{}"), ("tau.{}", "{}.effort", "{}.torque")
POSITION, VELOCITY = ("{}", "{}.pos", "q.{}"), ("{}.vel", "dq.{}")
RECORDED, COMMANDED, FREE = "recorded", "from commands and gains", "of a free motion"


@dataclass(frozen=True)
class Shown:
    """Motions of n joints.

    Attributes:
        rate_hz: of their rows.
        q, dq, torque: (rows, n) of each, rad, rad/s and N·m without what carries the weight.
        state: (rows, nstate) of each, what a policy sees.
        torques: where torques are from: `RECORDED`, `COMMANDED` or `FREE`.
    """

    rate_hz: float
    q: list[np.ndarray]
    dq: list[np.ndarray]
    torque: list[np.ndarray]
    state: list[np.ndarray]
    torques: str

    def poses(self, count: int) -> np.ndarray:
        """(count, n) rad, evenly in time over all motions."""
        q = np.concatenate(self.q)
        return q[np.linspace(0, len(q) - 1, count + 2).astype(int)[1:-1]]


def of_task(task: Demonstrated, demonstrations: Sequence[Demonstration]) -> Shown:
    """Of demonstrations of a task."""
    q = [d.qpos[:, task.arm_qpos] for d in demonstrations]
    dq = [d.dq for d in demonstrations]
    torque = [d.torque for d in demonstrations]
    state = [np.concatenate([d.qpos, d.dq], axis=1) for d in demonstrations]
    return Shown(1 / TIMESTEP_S, q, dq, torque, state, RECORDED)


def of_dataset(
    folder: Path,
    model: mujoco.MjModel,
    joints: tuple[str, ...],
    ranges: np.ndarray,
    gains: Gains | None,
    weighs: bool,
    degrees: bool = False,
) -> Shown:
    """Of a LeRobot data set on disk.

    Args:
        model: with `joints`, all others held.
        ranges: (n, 2) rad of the joints.
        gains: that it was recorded under, if they are known.
        weighs: whether the controller has to carry the weight too.
        degrees: positions and velocities are in degrees.

    Raises:
        RecordingError: it is no such data set, is of another robot, or has too few motions.
    """
    info = read_info(folder)
    where, unit = folder / "meta" / "info.json", np.pi / 180 if degrees else 1.0
    own, asked = (names_of(info.features[key].names) for key in (STATE, ACTION))
    at = _places(where, STATE, own, joints, POSITION)
    speeds, torques = _found(own, joints, VELOCITY), _found(asked, joints, TORQUE)
    commands = None
    if torques is None and gains is not None:
        commands = _places(where, ACTION, asked, joints, COMMAND)
    more = [ENVIRONMENT] if ENVIRONMENT in info.features else []
    for key in more:
        info.features[key] = feature_of(info.features, key, where)
    q, dq, torque, state = [], [], [], []
    for number, (_, read) in read_episodes(folder, info, more).items():
        rows = read[STATE][:, at] * unit
        command = rows if commands is None else read[ACTION][:, commands] * unit
        check_positions(folder, number, joints, command, rows, ranges)
        if len(rows) < max(3, LEAST_S * info.fps):
            raise RecordingError(
                folder, f"episode {number}", f"{len(rows)} frames", f"{LEAST_S:g} s or more"
            )
        speed = (
            np.gradient(rows, 1 / info.fps, axis=0) if speeds is None
            else read[STATE][:, speeds] * unit
        )  # fmt: skip
        q.append(rows)
        dq.append(speed)
        state.append(np.concatenate([read[key] for key in (STATE, *more)], axis=1))
        if torques is not None:
            torque.append(read[ACTION][:, torques])
        elif gains is not None:
            torque.append(pd_torque(command, rows, speed, gains.kp, gains.kd))
    if len(q) < FEWEST:
        raise RecordingError(folder, "the episodes", f"{len(q)}", f"{FEWEST} or more")
    source = RECORDED if torques is not None else FREE if gains is None else COMMANDED
    if not torque:
        torque = free_torques(model, joints, q, dq, info.fps, weighs)
    return Shown(info.fps, q, dq, torque, state, source)


def free_torques(
    model: mujoco.MjModel,
    joints: Sequence[str],
    q: Sequence[np.ndarray],
    dq: Sequence[np.ndarray],
    rate_hz: float,
    weighs: bool,
) -> list[np.ndarray]:
    """N·m (rows, n) that motions take by inverse dynamics, contacts and dry friction left out.

    Args:
        model: of `joints` alone.
        q, dq: (rows, n) of each, rad and rad/s.
        weighs: with the weight of the joints.
    """
    model = copy.copy(model)
    model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONSTRAINT
    model.body_gravcomp[:] = 0.0 if weighs else 1.0
    data = mujoco.MjData(model)
    places = [model.joint(name).qposadr[0] for name in joints]
    dofs = [model.joint(name).dofadr[0] for name in joints]
    found = []
    for rows, speeds in zip(q, dq, strict=True):
        torque = np.empty_like(rows)
        pushes = np.gradient(speeds, 1 / rate_hz, axis=0)
        for i, (here, speed, push) in enumerate(zip(rows, speeds, pushes, strict=True)):
            data.qpos[places], data.qvel[dofs], data.qacc[dofs] = here, speed, push
            mujoco.mj_inverse(model, data)
            torque[i] = data.qfrc_inverse[dofs]
        found.append(torque)
    return found


def _found(
    names: Sequence[str], joints: Sequence[str], patterns: Sequence[str]
) -> list[int] | None:
    """Where the joints' values are among names; None where one is not."""
    places = [
        next((names.index(p.format(joint)) for p in patterns if p.format(joint) in names), None)
        for joint in joints
    ]
    return None if None in places else places


def _places(where, key, names, joints, patterns) -> list[int]:
    places = _found(names, joints, patterns)
    if places is None:
        missing = next(j for j in joints if _found(names, [j], patterns) is None)
        raise RecordingError(
            where, f"key features.{key}.names", ", ".join(names) or "none",
            f"{missing} among them, as the robot's joints are {', '.join(joints)}; a data set of "
            "another robot says nothing about this one",
        )  # fmt: skip
    return places
