"""Closed-loop rollouts of one policy in one cell, all stepping together."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd

from t2l.actions import Control
from t2l.bc.episodes import PolicyEpisodes
from t2l.gains import Cell
from t2l.sim.batch import TIMESTEP_S
from t2l.tasks import Demonstrated
from t2l.tasks.cameras import Cameras

COLUMNS = ("kp", "kd", "rollout", "success", "time_to_success_s", "failure")
TRACE_COLUMNS = ("kp", "kd", "rollout", "success", "failure", "time_s", "qpos", "command")

# histories (n, history, nobs), and pictures of a policy that sees some, to chunks (n, chunk, nact)
ActionChunks = Callable[..., np.ndarray]


@dataclass(frozen=True)
class Rollouts:
    """Outcome of rollouts from given starts.

    Attributes:
        table: one row per rollout, columns `COLUMNS`.
        qpos: (ticks + 1, n, nq) positions at the policy's rate; a simulation that has ended
            keeps its last.
        command: (ticks, n, ncommand + ngripper) of the controller, then of the grippers.
    """

    table: pd.DataFrame
    qpos: np.ndarray
    command: np.ndarray


def roll_out(
    task: Demonstrated,
    act: ActionChunks,
    history: int,
    executed: int,
    control: Control,
    starts: np.ndarray,
    decimation: int,
    threads: int = 1,
    cameras: Cameras | None = None,
) -> Rollouts:
    """Roll out from every start until success, divergence or the task's horizon.

    Args:
        act: the policy.
        history: observations the policy sees.
        executed: actions of each chunk that are carried out before the policy is asked again.
        control: of a cell, in the task's model.
        starts: (n, nq).
        decimation: timesteps that each command is held for.
        cameras: of a policy that sees by them, and else the robot's own state alone. They are asked
            when the policy is.
    """
    episodes = PolicyEpisodes(task, control, starts, decimation, threads)
    n, ticks, grippers = len(starts), episodes.ticks, len(task.robot.grippers)
    own = task.robot_observation_size if cameras else None
    past = np.repeat(episodes.observation[:, None, :own], history, axis=1)
    qpos = np.empty((ticks + 1, n, task.model.nq))
    qpos[0] = episodes.qpos
    command = np.full((ticks, n, len(control.controller.command_names) + grippers), np.nan)
    chunk = np.empty((n, executed, len(control.actions.names) + grippers))
    while episodes.running.any():
        k = episodes.tick
        if k % executed == 0:
            chunk.fill(np.nan)
            running = episodes.running
            seen = (cameras.pictures(episodes.qpos[running]),) if cameras else ()
            chunk[running] = act(past[running], *seen)[:, :executed]
        command[k] = episodes.step(chunk[:, k % executed])
        qpos[k + 1] = episodes.qpos
        past = np.concatenate([past[:, 1:], episodes.observation[:, None, :own]], axis=1)
    qpos[episodes.tick + 1 :] = episodes.qpos

    failures = episodes.failures()
    table = pd.DataFrame(
        {
            "kp": control.cell.kp,
            "kd": control.cell.kd,
            "rollout": np.arange(n),
            "success": [failure == "" for failure in failures],
            "time_to_success_s": episodes.success_time_s,
            "failure": failures,
        },
        columns=list(COLUMNS),
    )
    return Rollouts(table=table, qpos=qpos, command=command)


def traces(rollouts: Rollouts, decimation: int) -> pd.DataFrame:
    """The first success and the first failure of each kind, a row a policy step, `TRACE_COLUMNS`.

    The last row of a rollout holds its final position and, as nothing follows, its last command.
    """
    shown = rollouts.table.drop_duplicates("failure")
    tables = []
    for row in shown.itertuples():
        sent = np.isfinite(rollouts.command[:, row.rollout]).all(axis=1)
        ticks = np.arange(sent.sum() + 1)
        command = rollouts.command[np.minimum(ticks, max(0, sent.sum() - 1)), row.rollout]
        tables.append(
            pd.DataFrame(
                {
                    "kp": row.kp,
                    "kd": row.kd,
                    "rollout": row.rollout,
                    "success": row.success,
                    "failure": row.failure,
                    "time_s": ticks * decimation * TIMESTEP_S,
                    "qpos": list(rollouts.qpos[ticks, row.rollout]),
                    "command": list(command),
                },
                columns=list(TRACE_COLUMNS),
            )
        )
    return pd.concat(tables, ignore_index=True)


def pick_traces(
    policies: Sequence[tuple[str, pd.DataFrame]], preferred: str
) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """A success and a failure of each kind, from the `preferred` cell where it has them.

    Args:
        policies: of each, its cell's name and its `traces`; those that come first are preferred.

    Returns:
        Per label, times (n,) s and positions (n, nq).
    """
    shown: dict[str, tuple[str, pd.DataFrame]] = {}
    for name, table in sorted(policies, key=lambda policy: policy[0] != preferred):
        for kind, rows in table.groupby("failure"):
            shown.setdefault(kind, (name, rows))
    picked = {}
    for kind, (name, rows) in sorted(shown.items()):
        what = ("failure", kind.replace("_", " ")) if kind else ("success",)
        label = "\n".join((*what, str(Cell.from_name(name))))
        picked[label] = (rows.time_s.to_numpy(), np.stack(rows.qpos))
    return picked
