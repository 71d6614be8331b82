"""Replaying retargeted demonstrations open loop, all at once, in one cell's simulation."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd

from t2l.actions import Control
from t2l.demos.demonstration import Demonstration
from t2l.demos.retarget import hold, retarget
from t2l.environment.episodes import Episodes
from t2l.errors import ReplayError
from t2l.gains import Cell
from t2l.tasks import Demonstrated

TABLE_COLUMNS = ("kp", "kd", "demonstration", "success", "failure", "mse_q_rad2")


@dataclass(frozen=True)
class Replay:
    """How one demonstration went under position control.

    Attributes:
        observation: (n, nobs) before each command.
        command: (n, ncommand), held, noise included.
        action: (n, naction) that leads to the command where the robot is then.
        gripper: (n, ngripper) commanded.
        success: whether the task was solved within the demonstration's length.
        failure: kind of failure, '' for a success.
        mse_q_rad2: mean squared joint position error against the demonstration.
    """

    observation: np.ndarray
    command: np.ndarray
    action: np.ndarray
    gripper: np.ndarray
    success: bool
    failure: str
    mse_q_rad2: float

    @property
    def episode(self) -> tuple[np.ndarray, np.ndarray]:
        """What a policy learns: observation, and action with the gripper commands, float32."""
        action = np.concatenate([self.action, self.gripper], axis=1, dtype=np.float32)
        return self.observation, action


def replay(
    task: Demonstrated,
    demonstrations: Sequence[Demonstration],
    control: Control,
    decimation: int,
    how: str = "mean",
    threads: int = 1,
    noise: Callable[[tuple[int, int, int]], np.ndarray] | None = None,
) -> list[Replay]:
    """Replay every demonstration with commands held for `decimation` timesteps.

    Args:
        control: of a cell, in the task's model.
        how: how a held command follows from those it replaces, see `t2l.demos.retarget.hold`.
        noise: of a shape (n, ticks, ncommand), to be added to the commands.
    """
    n, controller = len(demonstrations), control.controller
    commands = [hold(retarget(d, controller), decimation, how, controller) for d in demonstrations]
    grippers = [d.gripper[:-1:decimation] for d in demonstrations]
    lengths = np.array([len(c) for c in commands])
    ticks = int(lengths.max())
    command, gripper = _pad(commands, ticks), _pad(grippers, ticks)
    if noise is not None:
        command = command + noise(command.shape)
    reference = _pad([d.qpos[:, task.arm_qpos] for d in demonstrations], ticks * decimation + 1)

    starts = np.stack([d.qpos[0] for d in demonstrations])
    episodes = Episodes(task, controller, starts, decimation, threads)
    batch = episodes.batch
    observations = np.empty((n, ticks, len(task.observation_names)), dtype=np.float32)
    actions = np.empty((n, ticks, len(control.actions.names)))
    squared_error = np.zeros((n, ticks))
    before = controller.measured(batch)
    for k in range(ticks):
        observations[:, k] = task.observe(batch)
        actions[:, k] = control.actions.action(command[:, k], controller.measured(batch), before)
        before = command[:, k]
        episodes.hold(before, gripper[:, k])
        in_time = episodes.sound & (k < lengths)
        episodes.judge(in_time)
        error = batch.qpos[:, task.arm_qpos] - reference[:, (k + 1) * decimation]
        squared_error[:, k] = np.where(in_time, (error**2).mean(axis=1), np.nan)

    failures = episodes.failures()
    return [
        Replay(
            observation=observations[i, :m],
            command=command[i, :m],
            action=actions[i, :m],
            gripper=grippers[i],
            success=failures[i] == "",
            failure=failures[i],
            mse_q_rad2=float(squared_error[i, :m].mean()),
        )
        for i, m in enumerate(lengths)
    ]


def successful(replays: Sequence[Replay], cell: Cell) -> list[Replay]:
    """The replays to train on.

    Raises:
        ReplayError: fewer than two succeeded, too few to train and validate on.
    """
    kept = [r for r in replays if r.success]
    if len(kept) < 2:
        kinds = ", ".join(sorted({r.failure for r in replays if r.failure}))
        raise ReplayError(
            f"{cell}: {len(kept)} of {len(replays)} retargeted demonstrations succeed ({kinds}); "
            "at least 2 are needed. Take these gains out of grid, raise "
            "retargeting.policy_rate_hz, or hold the mean (retargeting.hold)."
        )
    return kept


def replay_table(replays: Sequence[Replay], cell: Cell) -> pd.DataFrame:
    """One row per replay, columns `TABLE_COLUMNS`."""
    rows = [
        (cell.kp, cell.kd, i, r.success, r.failure, r.mse_q_rad2) for i, r in enumerate(replays)
    ]
    return pd.DataFrame(rows, columns=list(TABLE_COLUMNS))


def _pad(sequences: Sequence[np.ndarray], length: int) -> np.ndarray:
    """Stack sequences of different lengths, the last row of each repeated to `length`."""
    return np.stack([s[np.minimum(np.arange(length), len(s) - 1)] for s in sequences])
