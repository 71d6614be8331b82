"""Policies cloned under all gains of some worlds, and how often each succeeds on the machine.

Demonstrations are retargeted to the gains of a cell as the project does it, `POLICIES` networks of
a cell are trained from seeds of their own, all of a robot side by side, and each is tried from the
same starts as all others of its world. At first `FIRST` times, or `HOPE` times if none succeeds by
then; where a cell's mean success comes within `NEAR` of the best cell's, `THEN` times more from
other starts.
"""

from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from functools import cache
from multiprocessing import get_context

import numpy as np
import pandas as pd

from benchmarks.planted.episode import POLICY_HZ, ROWS_HZ, Attempt, attempted
from benchmarks.planted.shown import Demonstration
from benchmarks.planted.world import World

POLICIES = 4
FIRST, HOPE, THEN, NEAR = 8, 4, 24, 0.2
VALIDATION = 0.1  # share of the demonstrations
EXECUTED = 10  # actions of a chunk, as the project's studies do by default
COLUMNS = ("world", "kp", "kd", "policy", "validation_loss", "stage", "rollouts", "successes")


@dataclass(frozen=True)
class Cloned:
    """One policy: `tensors` and `metadata` make it again."""

    world: int
    cell: int
    number: int
    validation_loss: float
    tensors: Mapping[str, np.ndarray]
    metadata: Mapping


def episodes(world: World, shown: Sequence[Demonstration], cell: int) -> list:
    """Demonstrations as a policy of a cell learns from them."""
    from t2l.advise.retargeted import commands
    from t2l.policies import Episode

    gains = (np.full((1, len(world.joints)), gain) for gain in world.cells[cell])
    kp, kd = gains
    steps = ROWS_HZ // POLICY_HZ
    return [
        Episode(
            one.observation.astype(np.float32),
            commands(one.q, one.dq, one.torque, kp, kd, steps)[0].astype(np.float32),
        )
        for one in shown
    ]


def trained(
    numbers: Sequence[int],
    some: Sequence[World],
    shown: Sequence[Sequence[Demonstration]],
    policies: int = POLICIES,
    **settings,
) -> list[Cloned]:
    """All policies of worlds of one robot, side by side.

    Args:
        numbers: of the worlds, which the policies then have.
        shown: of each world.
    """
    from t2l.policies.chunk_regression import ChunkRegression
    from t2l.policies.policy import TrainingSet

    members, sets = [], []
    for number, world, one in zip(numbers, some, shown, strict=True):
        held = max(1, round(VALIDATION * len(one)))
        for cell in range(len(world.cells)):
            own = episodes(world, one, cell)
            for policy in range(policies):
                seed = int(world.rng(1, cell, policy).integers(2**31))
                order = np.random.default_rng(seed).permutation(len(own))
                parts = [[own[i] for i in which] for which in (order[held:], order[:held])]
                members.append((number, cell, policy))
                sets.append(TrainingSet(*parts, seed))
    made = ChunkRegression.fit_side_by_side(sets, ChunkRegression.settings(**settings))
    return [
        Cloned(*who, float(losses.validation_loss.iloc[-1]), policy.tensors(), policy.metadata())
        for who, (policy, losses) in zip(members, made, strict=True)
    ]


@dataclass(frozen=True)
class _Job:
    world: World
    policy: Cloned
    stage: int
    rollouts: int


def _tried(job: _Job) -> tuple[int, int]:
    """How often a policy was tried, and how often it succeeded."""
    policy = _policy(job.policy)
    kp, kd = (np.full(len(job.world.joints), gain) for gain in job.world.cells[job.policy.cell])
    count = 0
    for number in range(job.rollouts):
        rng = job.world.rng(2, job.stage, number)
        attempt = Attempt.drawn(job.world, rng)
        attempted(attempt, kp, kd, _Acting(policy), rng)
        count += attempt.success
        if job.stage == 0 and number + 1 == HOPE and not count:
            return HOPE, 0
    return job.rollouts, count


def _policy(made: Cloned):
    from t2l.policies.chunk_regression import ChunkRegression

    return ChunkRegression.restored(made.tensors, made.metadata)


class _Acting:
    """A policy that carries out `EXECUTED` actions of a chunk, then looks again."""

    def __init__(self, policy):
        self.policy, self.past, self.tick = policy, None, 0

    def __call__(self, observation: np.ndarray, link: np.ndarray) -> np.ndarray:
        seen = np.nan_to_num(observation, posinf=1e6, neginf=-1e6)[None]
        if self.past is None:
            self.past = np.repeat(seen, self.policy.history, axis=0)
        self.past = np.concatenate([self.past[1:], seen])
        at = self.tick % EXECUTED
        if at == 0:
            self.chunk = self.policy.act(self.past[None])[0]
        self.tick += 1
        return self.chunk[at]


@cache
def _quiet() -> None:
    import mujoco
    import torch

    torch.set_num_threads(1)
    mujoco.set_mju_user_warning(lambda message: None)


def tried(
    worlds: Sequence[World], policies: Sequence[Cloned], processes: int
) -> Iterator[pd.DataFrame]:
    """Rows of `COLUMNS`, first of all policies, then of those of the better cells."""
    with ProcessPoolExecutor(processes, get_context("spawn"), initializer=_quiet) as pool:
        first = _rows(worlds, policies, 0, FIRST, pool)
        yield first
        share = first.assign(share=first.successes / first.rollouts)
        means = share.groupby(["world", "kp", "kd"]).share.mean()
        best = means.groupby("world").transform("max")
        near = set(means.index[means >= best - NEAR])
        left = [
            one for one in policies
            if (worlds[one.world].name, *worlds[one.world].cells[one.cell]) in near
        ]  # fmt: skip
        yield _rows(worlds, left, 1, THEN, pool)


def _rows(worlds, policies, stage: int, rollouts: int, pool) -> pd.DataFrame:
    jobs = [_Job(worlds[one.world], one, stage, rollouts) for one in policies]
    rows = [
        (
            job.world.name, *job.world.cells[job.policy.cell], job.policy.number,
            round(job.policy.validation_loss, 6), stage, *count,
        )
        for job, count in zip(jobs, pool.map(_tried, jobs), strict=True)
    ]  # fmt: skip
    return pd.DataFrame(rows, columns=list(COLUMNS))
