"""Closed-loop rollouts of one policy in one cell, all stepping together."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
import pandas as pd

from t2l.actions import Control
from t2l.gains import Cell
from t2l.sim import make_batch
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

    def observe() -> np.ndarray:
        return task.observe(batch)[:, : task.robot_observation_size if cameras else None]

    n = len(starts)
    tick_s = decimation * TIMESTEP_S
    ticks = round(task.horizon_s / tick_s)
    controller, grippers = control.controller, len(task.robot.grippers)
    size, width = len(control.actions.names), len(controller.command_names)

    batch = make_batch(task.model, n, threads)
    controller.install(batch)
    task.reset(batch, starts)
    monitor = task.monitor(n)
    sound = np.ones(n, dtype=bool)
    active = sound.copy()
    past = np.repeat(observe().astype(np.float32)[:, None], history, axis=1)
    qpos = np.empty((ticks + 1, n, task.model.nq))
    qpos[0] = batch.qpos
    command = np.full((ticks, n, width + grippers), np.nan)
    chunk = np.empty((n, executed, size + grippers))
    before = np.concatenate([controller.measured(batch), np.tile(task.opened, (n, 1))], axis=1)
    for k in range(ticks):
        if k % executed == 0:
            chunk.fill(np.nan)
            seen = (cameras.pictures(batch.qpos[active]),) if cameras else ()
            chunk[active] = act(past[active], *seen)[:, :executed]
        action, gripper = np.split(chunk[:, k % executed], [size], axis=1)
        arm = control.actions.command(action, controller.measured(batch), before[:, :width])
        command[k] = np.concatenate([arm, gripper], axis=1)
        # a policy that answers NaN has failed; its simulation must not be fed one
        diverging = active & ~np.isfinite(command[k]).all(axis=1)
        sound &= ~diverging
        active &= ~diverging
        # what has ended is sent what it was sent last
        before = np.where(active[:, None], command[k], before)
        task.command_grippers(batch.ctrl, before[:, width:])
        controller.step(batch, before[:, :width], active, decimation)
        monitor.update(batch, (k + 1) * tick_s, active)
        finished = ~np.isnan(monitor.success_time_s)
        sound &= active | finished
        active &= ~finished
        qpos[k + 1] = np.where(sound[:, None], batch.qpos, qpos[k])
        if not active.any():
            qpos[k + 2 :] = qpos[k + 1]
            break
        past = np.concatenate([past[:, 1:], observe()[:, None]], axis=1, dtype=np.float32)

    failures = monitor.failures(sound)
    table = pd.DataFrame(
        {
            "kp": control.cell.kp,
            "kd": control.cell.kd,
            "rollout": np.arange(n),
            "success": [failure == "" for failure in failures],
            "time_to_success_s": monitor.success_time_s,
            "failure": failures,
        },
        columns=list(COLUMNS),
    )
    return Rollouts(table=table, qpos=qpos, command=command)


def traces(rollouts: Rollouts, decimation: int) -> pd.DataFrame:
    """The first success and the first failure, one row per policy step, columns `TRACE_COLUMNS`.

    The last row of a rollout holds its final position and, as nothing follows, its last command.
    """
    shown = rollouts.table.drop_duplicates("success")
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
    by_cell: Mapping[str, pd.DataFrame], preferred: str
) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """A success and a failure, from the `preferred` cell where it has them.

    Args:
        by_cell: `traces` of every cell, by the cell's name.

    Returns:
        Per label, times (n,) s and positions (n, nq).
    """
    picked = {}
    order = sorted(by_cell, key=lambda name: name != preferred)
    for wanted, word in ((True, "success"), (False, "failure")):
        for name in order:
            rows = by_cell[name][by_cell[name].success == wanted]
            if len(rows):
                kind = rows.failure.iloc[0].replace("_", " ")
                label = "\n".join(filter(None, (word, kind, str(Cell.from_name(name)))))
                picked[label] = (rows.time_s.to_numpy(), np.stack(rows.qpos))
                break
    return picked
