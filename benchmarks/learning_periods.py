"""What weights of a second change while a task is learned, beside weights of a step.

`python -m benchmarks learning_periods [TASK …] [--seeds N]` brings docs/data/learning_periods.csv
up to trainings of these tasks from the seeds 1 to N, of all tasks and seeds where none are named.
Weights of a step pay as much a step as those of a second pay a second. Rows of other tasks and
seeds stay. 2 to 3 minutes of a core a training of `open_drawer`, 1 to 2 of the others.
"""

import argparse
from collections.abc import Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace
from typing import NamedTuple

import numpy as np
import pandas as pd
from stable_baselines3.common.utils import explained_variance
from stable_baselines3.ppo import PPO

from benchmarks.scene import ROOT, task_file
from t2l.artefacts import write_text
from t2l.gains import Cell
from t2l.rl.alone import problem_of, train_alone
from t2l.rl.settings import Settings
from t2l.threads import one_thread

TABLE = ROOT / "docs/data/learning_periods.csv"
CELL = Cell(512.0, 24.0)
SCALE_RAD, RATE_HZ, PHYSICS_HZ, ROBOTS = (0.2, 0.2), 50.0, 200.0, 64
KEYS = ["task", "weights_of", "kp", "kd", "seed"]
LAST = 20  # updates that the value is told of


class Size(NamedTuple):
    """Of the trainings of a task."""

    seeds: int
    updates: int
    evaluate_every: int
    horizon_s: float


SIZES: Mapping[str, Size] = {
    "open_drawer": Size(4, 80, 20, 8.0),
    "lift_cube": Size(3, 100, 50, 5.0),
    "reorient_cube": Size(3, 100, 50, 5.0),
}


def main(arguments: Sequence[str]) -> pd.DataFrame:
    """What the command line asks for: the rows that were trained, which are written too."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks learning_periods")
    parser.add_argument("tasks", nargs="*", metavar="TASK", help="of three (default: all)")
    parser.add_argument("--seeds", type=int, help="of each, counted from 1 (default: all)")
    asked = parser.parse_args(arguments)
    if unknown := sorted(set(asked.tasks) - set(SIZES)):
        parser.error(f"found {', '.join(unknown)}; allowed: {', '.join(SIZES)}")
    one_thread()
    found = pd.DataFrame(
        [
            trained(task, SIZES[task], of, seed)
            for task in asked.tasks or SIZES
            for of in ("second", "step")
            for seed in range(1, 1 + (asked.seeds or SIZES[task].seeds))
        ]
    )
    kept = pd.read_csv(TABLE)
    again = kept.set_index(KEYS).index.isin(found.set_index(KEYS).index)
    table = pd.concat([kept[~again], found[kept.columns]])
    order = [*SIZES]
    table = table.sort_values(KEYS, key=lambda c: c.map(order.index) if c.name == "task" else c)
    write_text(table.to_csv(index=False), TABLE)
    return found


def trained(task: str, size: Size, weights_of: str, seed: int) -> dict[str, object]:
    """One row: how often the policy succeeds, what it is paid a second, what its value explains."""
    entry = {
        "task": task, "policy_rate_hz": RATE_HZ, "rate_hz": PHYSICS_HZ, "horizon_s": size.horizon_s,
        "actions": {"kind": "joint_delta", "reference": "measured"},
        "action_scales": [{"kp": CELL.kp, "kd": CELL.kd, "rad": [*SCALE_RAD]}],
    }  # fmt: skip
    problem, choice = problem_of(entry, task_file(task), CELL)
    per_second = 1.0
    if weights_of == "step":
        per_second = RATE_HZ
        weights = {name: weight * RATE_HZ for name, weight in problem.task.weights.items()}
        choice = replace(choice, reward_weights=weights)
    settings = Settings(
        algorithm="ppo", environments=ROBOTS, updates=size.updates,
        evaluate_every=size.evaluate_every, seed=42, observation_noise_rad=0.0,
        observation_noise_rad_s=0.0, clip_actions=True, shared_network=True,
    )  # fmt: skip
    with explained() as shares:
        result, row, _ = train_alone(problem, choice, settings, seed, threads=1)
    return {
        "task": task, "weights_of": weights_of, "kp": int(CELL.kp), "kd": int(CELL.kd),
        "seed": seed, "steps": row["steps"], "successes": row["successes"],
        "episodes": row["episodes"],
        "reward": float(f"{result.history.reward.iloc[-1] / per_second:.5g}"),
        "explained_variance": float(f"{np.mean(shares[-LAST:]):.5g}"),
    }  # fmt: skip


@contextmanager
def explained():
    """Of each update of PPO meanwhile, the share of the variance of returns that values explain."""
    plain, shares = PPO.train, []

    def train(self: PPO) -> None:
        buffer = self.rollout_buffer
        shares.append(explained_variance(buffer.values.flatten(), buffer.returns.flatten()))
        plain(self)

    PPO.train = train
    try:
        yield shares
    finally:
        PPO.train = plain
