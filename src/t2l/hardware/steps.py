"""How a robot answers a step of its command, joint by joint."""

from typing import TYPE_CHECKING

import numpy as np

from t2l.gains import Cell
from t2l.hardware.backend import Backend, BeyondLimitError
from t2l.hardware.motion import Motion
from t2l.recordings.recording import Recording

if TYPE_CHECKING:
    import pandas as pd

STEP_RAD = 0.1
# of a joint that a larger step makes too fast: down to a sixteenth
HALVINGS = 4
BEFORE_S, AFTER_S = 0.1, 1.9
RATE_HZ = 100.0  # of the samples; the command is constant after the step
COLUMNS = ("kp", "kd", "joint", "time", "q_des", "q")


def shown_joints(arm: Backend) -> list[int]:
    """The last joint that is proximal, and the last of all: of the FR3 the elbow and the flange."""
    proximal = np.flatnonzero(arm.robot.proximal)
    return list(dict.fromkeys([int(proximal[-1]), len(arm.robot.joints) - 1]))


def step_responses(arm: Backend, cell: Cell) -> "pd.DataFrame":
    """Steps from home, one joint at a time.

    Each is of `STEP_RAD`, or half as large until the robot, which must be a simulation, keeps its
    limits.

    Returns:
        One row a sample, columns `COLUMNS`: time in s from the step, q_des and q in rad from home.
    """
    import pandas as pd

    robot, tables = arm.robot, []
    gains = [np.full(len(robot.joints), float(gain)) for gain in (cell.kp, cell.kd)]
    time = np.arange(round((BEFORE_S + AFTER_S) * RATE_HZ)) / RATE_HZ - BEFORE_S
    for joint in shown_joints(arm):
        recording = _stepped(arm, joint, time, *gains)
        tables.append(
            pd.DataFrame(
                {
                    "kp": cell.kp, "kd": cell.kd, "joint": robot.joints[joint],
                    "time": recording.time - recording.time[0] - BEFORE_S,
                    "q_des": recording.q_des[:, joint] - robot.home[joint],
                    "q": recording.q[:, joint] - robot.home[joint],
                }
            )
        )  # fmt: skip
    return pd.concat(tables, ignore_index=True)


def _stepped(
    arm: Backend, joint: int, time: np.ndarray, kp: np.ndarray, kd: np.ndarray
) -> Recording:
    """The largest step of a joint that keeps all limits."""
    name, home = f"step_{arm.robot.joints[joint]}", np.tile(arm.robot.home, (len(time), 1))
    halved = 0
    while True:
        q_des = home.copy()
        q_des[time >= -1e-9, joint] += STEP_RAD / 2**halved
        try:
            return arm.record(Motion(name, q_des, RATE_HZ, kp, kd))
        except BeyondLimitError:
            if halved == HALVINGS:
                raise
            halved += 1
