"""Demonstrations that operators give through a cell's own controller, nothing retargeted."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd

from t2l.actions import Control
from t2l.demos.operator import Operator, Person
from t2l.environment.episodes import Episodes
from t2l.errors import OperatorError
from t2l.gains import Cell
from t2l.tasks import Demonstrated

TABLE_COLUMNS = ("kp", "kd", "demonstration", "success", "failure", "time_s", "crossover_rad_s")
ATTEMPTS_AT_ONCE = 128


@dataclass(frozen=True)
class Attempt:
    """How an operator did.

    Attributes:
        episode: what a policy learns: observation (n, nobs) before each command, and action with
            the gripper commands (n, naction + ngripper), float32.
        failure: kind of failure, '' for a success.
        time_s: until the operator was done, or the task's time was up.
        crossover_rad_s: of the operator.
    """

    episode: tuple[np.ndarray, np.ndarray]
    failure: str
    time_s: float
    crossover_rad_s: float

    @property
    def success(self) -> bool:
        """Whether the task was solved."""
        return self.failure == ""


def collect(
    task: Demonstrated,
    control: Control,
    decimation: int,
    count: int,
    max_attempts: int,
    person: Person,
    rng: np.random.Generator,
    threads: int = 1,
) -> list[Attempt]:
    """Attempts from random starts, up to the one with the `count`-th success.

    Of several crossover frequencies, the operator takes the one that succeeds most often in
    practice, of equals the quickest. What was done in practice is not kept.

    Args:
        control: of a cell, in the task's model.
        decimation: timesteps that each command is held for.

    Raises:
        OperatorError: fewer than two of `max_attempts` succeeded, too few to train and validate on.
    """
    crossover, *others = person.crossover_rad_s
    if others:
        # of its own, so that every cell begins with the same starts, and with the expert's
        practising = rng.spawn(1)[0]
        each = np.repeat(person.crossover_rad_s, person.practice)
        starts = task.sample_starts(practising, len(each))
        tried = attempt(task, control, decimation, starts, person, each, practising, threads)
        crossover = _best(tried)
    attempts: list[Attempt] = []
    missing = count
    while missing and len(attempts) < max_attempts:
        n = min(missing, max_attempts - len(attempts), ATTEMPTS_AT_ONCE)
        starts = task.sample_starts(rng, n)
        attempts += attempt(task, control, decimation, starts, person, crossover, rng, threads)
        missing = count - sum(a.success for a in attempts)
    if (won := count - missing) < 2:
        kinds = ", ".join(sorted({a.failure for a in attempts if a.failure}))
        raise OperatorError(
            f"{control.cell}: {won} of {len(attempts)} attempts of the operator succeed ({kinds}); "
            "at least 2 are needed. Take these gains out of grid, raise "
            "demonstrations.max_attempts, or change operator."
        )
    return attempts


def attempt(
    task: Demonstrated,
    control: Control,
    decimation: int,
    starts: np.ndarray,
    person: Person,
    crossover_rad_s: np.ndarray | float,
    rng: np.random.Generator,
    threads: int = 1,
) -> list[Attempt]:
    """One attempt from each of `starts` (n, nq), until it is done or the task's time is up.

    Args:
        crossover_rad_s: (n,) or one number.
    """
    n, controller = len(starts), control.controller
    episodes = Episodes(task, controller, starts, decimation, threads)
    batch, tick_s = episodes.batch, episodes.tick_s
    ticks, lengths = round(task.horizon_s / tick_s), np.zeros(n, int)
    operator = Operator(task, control, batch, starts, tick_s, person, crossover_rad_s, rng)
    observations = np.empty((n, ticks, len(task.observation_names)), dtype=np.float32)
    actions, grippers = [], []
    before = controller.measured(batch).copy()
    for k in range(ticks):
        observations[:, k] = task.observe(batch)
        command, gripper = operator.act(episodes.sound & ~operator.finished)
        actions.append(control.actions.action(command, controller.measured(batch), before))
        grippers.append(gripper)
        before = command
        episodes.hold(command, gripper)
        busy = episodes.sound & ~operator.finished
        episodes.judge(busy)
        lengths[busy] = k + 1
        if not busy.any():
            break
    failures = episodes.failures()
    labels = np.concatenate([actions, grippers], axis=2, dtype=np.float32).swapaxes(0, 1)
    crossover = np.broadcast_to(crossover_rad_s, n)
    return [
        Attempt(
            episode=(observations[i, :m], labels[i, :m]),
            failure=failures[i],
            time_s=float(m * tick_s),
            crossover_rad_s=float(crossover[i]),
        )
        for i, m in enumerate(lengths)
    ]


def attempt_table(attempts: Sequence[Attempt], cell: Cell) -> pd.DataFrame:
    """One row an attempt, columns `TABLE_COLUMNS`."""
    rows = [
        (cell.kp, cell.kd, i, a.success, a.failure, a.time_s, a.crossover_rad_s)
        for i, a in enumerate(attempts)
    ]
    return pd.DataFrame(rows, columns=list(TABLE_COLUMNS))


def _best(tried: Sequence[Attempt]) -> float:
    """The crossover frequency that succeeded most often, of equals the quickest."""
    rows = pd.DataFrame([(a.crossover_rad_s, a.success, a.time_s) for a in tried])
    order = rows.groupby(0).mean().sort_values([1, 2], ascending=[False, True])
    return float(order.index[0])
