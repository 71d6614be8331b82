"""Physics steps a second of replays and rollouts, against a bare Batch.step on the same motions."""

import time
from collections.abc import Callable

import numpy as np
import pandas as pd

from benchmarks.scene import block_stack, demonstrations, paper
from t2l.actions import Control, make_control
from t2l.bc.rollout import Rollouts, roll_out
from t2l.demos.replay import replay
from t2l.gains import Cell
from t2l.policies import POLICIES, Episode, Policy
from t2l.sim import apply_position_gains, make_batch
from t2l.tasks import Task

CELL = Cell(256, 8)
DECIMATION = 10
REPEATS = 3


def run() -> pd.DataFrame:
    """Medians over interleaved repeats, so that a drifting machine shifts both sides alike."""
    task = block_stack()
    return pd.DataFrame(
        [
            compare(task, threads)
            for threads in (1, 2)
            for compare in (_compare_replays, _compare_rollouts)
        ]
    )


def _compare_replays(task: Task, threads: int) -> dict:
    demos = demonstrations(task, 100)
    replays = replay(task, demos, _control(task), DECIMATION)
    ticks = max(len(r.command) for r in replays)
    commands = np.stack(
        [
            np.column_stack([r.command, r.gripper])[
                np.minimum(np.arange(ticks), len(r.command) - 1)
            ]
            for r in replays
        ]
    )
    starts = np.stack([d.qpos[0] for d in demos])
    return _compare(
        f"TPR replay, 100 at once, {threads} thread(s)",
        lambda: replay(task, demos, _control(task), DECIMATION, threads=threads),
        lambda: _bare(task, starts, commands, threads),
        len(demos) * ticks * DECIMATION,
    )


def _compare_rollouts(task: Task, threads: int) -> dict:
    starts = task.sample_starts(np.random.default_rng(1), 100)
    policy, control = _policy(task), _control(task)

    def rollouts() -> Rollouts:
        return roll_out(task, policy.act, policy.history, 10, control, starts, DECIMATION, threads)

    commands = rollouts().command.transpose(1, 0, 2)
    assert np.isfinite(commands).all(), "a rollout ended early: the comparison would not be fair"
    return _compare(
        f"policy rollouts with inference, 100 at once, {threads} thread(s)",
        rollouts,
        lambda: _bare(task, starts, commands, threads),
        commands.shape[0] * commands.shape[1] * DECIMATION,
    )


def _compare(what: str, ours: Callable, bare: Callable, steps: int) -> dict:
    times = np.array([[_seconds(ours), _seconds(bare)] for _ in range(REPEATS)])
    ratios = times[:, 1] / times[:, 0]
    ours_s, bare_s = np.median(times, axis=0)
    return {
        "what": what,
        "steps/s": f"{steps / ours_s:,.0f}",
        "bare Batch.step steps/s": f"{steps / bare_s:,.0f}",
        "ratio (min to max)": f"{np.median(ratios):.2f} ({ratios.min():.2f} to {ratios.max():.2f})",
        "wanted": "at least 0.60",
    }


def _seconds(call: Callable) -> float:
    start = time.perf_counter()
    call()
    return time.perf_counter() - start


def _bare(task: Task, starts: np.ndarray, commands: np.ndarray, threads: int) -> None:
    """Nothing but commands in and steps: what MuJoCo can do at most on these motions."""
    batch = make_batch(task.model, len(starts), threads)
    apply_position_gains(batch, task.robot.joints, CELL.kp, CELL.kd)
    task.reset(batch, starts)
    for k in range(commands.shape[1]):
        task.command(batch.ctrl, commands[:, k, :-1], commands[:, k, -1:])
        batch.step(nstep=DECIMATION)


def _control(task: Task) -> Control:
    return make_control({"kind": "joint_target"}, CELL, task.robot, task.model)


def _policy(task: Task) -> Policy:
    """The nominal policy, hardly trained, and that on standing still, so that no rollout ends."""
    section = {**paper()["training"], "epochs": 1}
    policy = POLICIES.find(section.pop("policy"))
    del section["validation_fraction"]
    rng = np.random.default_rng(0)
    still = np.array([*task.robot.home, *task.opened])
    episodes = [
        Episode(
            np.zeros((100, len(task.observation_names)), np.float32),
            (still + 0.2 * rng.normal(size=(100, len(still)))).astype(np.float32),
        )
        for _ in range(2)
    ]
    return policy.fit(episodes[:1], episodes[1:], policy.settings(**section), seed=0)[0]
