"""Open-loop replays under noise on every command.

The study (its Sec. IV-A) replays the same commands in every cell and adds random noise at each
step, whose largest magnitude follows from the validation loss of the policies.
"""

from collections.abc import Callable, Sequence

import numpy as np
import pandas as pd

from t2l.actions import Control
from t2l.demos.demonstration import Demonstration
from t2l.demos.replay import TABLE_COLUMNS, Replay, replay, replay_table
from t2l.gains import Cell
from t2l.tasks import Demonstrated

# how large the noise of a cell is: as in every cell, or as that cell's own validation error is
CONDITIONS = ("same", "own")
COLUMNS = (*TABLE_COLUMNS, "condition", "magnitude_rad")
TRACE_COLUMNS = ("kp", "kd", "condition", "replay", "time_s")
TRACES = 5


def magnitudes(cells: pd.DataFrame, cell: Cell) -> dict[str, float]:
    """The largest noise on a command in rad, for each of `CONDITIONS`.

    `same` is the root of the mean over cells of the validation error, `own` that of the cell.

    Args:
        cells: one row a cell, with its `loss` in rad², see `success.by_cell`.
    """
    own = cells.loss[(cells.kp == cell.kp) & (cells.kd == cell.kd)]
    return {"same": float(np.sqrt(cells.loss.mean())), "own": float(np.sqrt(own.iloc[0]))}


def uniform(magnitude: float, rng: np.random.Generator) -> Callable[..., np.ndarray]:
    """Noise for `t2l.demos.replay.replay`: uniform between plus and minus `magnitude`."""
    return lambda shape: rng.uniform(-magnitude, magnitude, shape)


def noisy_replays(
    task: Demonstrated,
    demonstrations: Sequence[Demonstration],
    control: Control,
    decimation: int,
    hold: str,
    magnitude: float,
    count: int,
    rng: np.random.Generator,
    threads: int = 1,
) -> list[Replay]:
    """`count` replays, of each demonstration in turn, each with noise of its own.

    Args:
        control, decimation, hold: see `t2l.demos.replay.replay`.
    """
    chosen = [demonstrations[i % len(demonstrations)] for i in range(count)]
    return replay(task, chosen, control, decimation, hold, threads, uniform(magnitude, rng))


def noise_table(
    replays: Sequence[Replay], cell: Cell, condition: str, magnitude: float
) -> pd.DataFrame:
    """One row a replay, columns `COLUMNS`; `demonstration` counts the replays."""
    return replay_table(replays, cell).assign(condition=condition, magnitude_rad=magnitude)


def traces(
    task: Demonstrated,
    demonstration: Demonstration,
    control: Control,
    decimation: int,
    hold: str,
    magnitude: float,
    rng: np.random.Generator,
) -> pd.DataFrame:
    """Joint positions over one demonstration's replay, undisturbed and `TRACES` times with noise.

    Returns:
        One row a command and replay: `TRACE_COLUMNS` and `q.JOINT` in rad for each joint.
        `condition` is `none` or `same`.
    """
    noise = uniform(magnitude, rng)

    def all_but_the_first(shape):
        added = noise(shape)
        added[0] = 0.0
        return added

    replays = replay(
        task, [demonstration] * (1 + TRACES), control, decimation, hold, 1, all_but_the_first
    )
    joints = task.robot.joints
    tables = []
    for i, one in enumerate(replays):
        positions = pd.DataFrame(
            one.observation[:, : len(joints)], columns=[f"q.{joint}" for joint in joints]
        )
        time_s = np.arange(len(positions)) * decimation * task.model.opt.timestep
        marks = {
            "kp": control.cell.kp,
            "kd": control.cell.kd,
            "condition": "same" if i else "none",
            "replay": i,
            "time_s": time_s,
        }
        tables.append(pd.concat([pd.DataFrame(marks), positions], axis=1))
    return pd.concat(tables, ignore_index=True)
