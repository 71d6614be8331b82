"""Physics steps a second of replays and rollouts, against a bare Batch.step on the same motions.

One thread each, as jobs of the workflow have. Time is the processor's, which others on the machine
disturb less.
"""

import time
from collections.abc import Callable, Iterator
from copy import copy

import numpy as np
import pandas as pd

from benchmarks.recorded_steps import recorded
from benchmarks.scene import demonstrations, paper, tasks
from t2l.actions import Control, make_control
from t2l.bc.rollout import roll_out
from t2l.demos.replay import replay
from t2l.gains import Cell
from t2l.policies import POLICIES, Episode, Policy
from t2l.sim import make_batch
from t2l.tasks import Demonstrated

AT_ONCE = 100
DECIMATION = 10
REPEATS = 3
BOUND = 0.8
# what actions mean, and a cell for it: stiffness and damping in its controller's units
JOINT_SPACE = "joint_target", Cell(256, 8)
TASK_SPACE = "task_pose", Cell(256, 32)
IN_TASK_SPACE = ("block_stack",)
# rollouts stand still, and every step of theirs takes as long as the one before
ROLLOUT_S = 3.0


def run() -> pd.DataFrame:
    """Medians over interleaved repeats, so that a drifting machine shifts both sides alike."""
    import torch

    threads = torch.get_num_threads()
    torch.set_num_threads(1)
    try:
        rows = [row for name, task in tasks(Demonstrated) for row in _rows(name, task)]
    finally:
        torch.set_num_threads(threads)
    return pd.DataFrame(rows)


def _rows(name: str, task: Demonstrated) -> Iterator[dict]:
    demos = demonstrations(task, AT_ONCE)
    short = copy(task)
    short.horizon_s = ROLLOUT_S
    starts = task.sample_starts(np.random.default_rng(1), AT_ONCE)
    for kind, cell in (JOINT_SPACE, TASK_SPACE) if name in IN_TASK_SPACE else (JOINT_SPACE,):
        control = make_control({"kind": kind}, cell, task.robot, task.model)
        policy = _policy(short, control)

        def replays(control: Control = control) -> None:
            replay(task, demos, control, DECIMATION)

        def rollouts(control: Control = control, policy: Policy = policy) -> None:
            done = roll_out(short, policy.act, policy.history, 10, control, starts, DECIMATION)
            whole = np.isfinite(done.command).all()
            assert whole, "a rollout ended early: the comparison would not be fair"

        for what, chain in (("replays", replays), ("rollouts", rollouts)):
            yield {"task": name, "actions": kind, "what": what} | _compared(chain)


def _compared(chain: Callable[[], None]) -> dict:
    with recorded() as made:
        chain()
    [steps] = made
    times = np.array([[_seconds(chain), _seconds(steps.again)] for _ in range(REPEATS)])
    ratios = times[:, 1] / times[:, 0]
    ours_s, bare_s = np.median(times, axis=0)
    return {
        "steps/s": f"{steps.count / ours_s:,.0f}",
        "bare Batch.step steps/s": f"{steps.count / bare_s:,.0f}",
        "ratio (min to max)": f"{np.median(ratios):.2f} ({ratios.min():.2f} to {ratios.max():.2f})",
        "wanted": f"at least {BOUND:.2f}",
    }


def _seconds(call: Callable[[], None]) -> float:
    start = time.process_time()
    call()
    return time.process_time() - start


def _policy(task: Demonstrated, control: Control) -> Policy:
    """The nominal policy, hardly trained, and that on standing still, so that no rollout ends."""
    section = {**paper()["training"], "epochs": 1}
    policy = POLICIES.find(section.pop("policy"))
    del section["validation_fraction"]
    rng = np.random.default_rng(0)
    still = np.concatenate([_home(task, control), task.opened])
    episodes = [
        Episode(
            np.zeros((100, len(task.observation_names)), np.float32),
            (still + 0.2 * rng.normal(size=(100, len(still)))).astype(np.float32),
        )
        for _ in range(2)
    ]
    return policy.fit(episodes[:1], episodes[1:], policy.settings(**section), seed=0)[0]


def _home(task: Demonstrated, control: Control) -> np.ndarray:
    """(naction,) that keeps the robot where it is at home."""
    batch = make_batch(task.model, 1)
    control.controller.install(batch)
    qpos = task.model.qpos0[None].copy()
    qpos[:, task.arm_qpos] = task.robot.home
    task.reset(batch, qpos)
    there = control.controller.measured(batch)
    return control.actions.action(there, there, there)[0]
