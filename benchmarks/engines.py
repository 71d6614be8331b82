"""Steps a second of tasks with contacts, on the processor and on a GPU, beside the bare engine's.

`python -m benchmarks engines [DEVICE …]`: `mujoco`, `cuda`, or MuJoCo Warp's `cpu`. A step is one
of the physics. Actions are random, so hands meet tables, cubes and cabinets.
"""

import os
import time
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
import pandas as pd
import yaml

from t2l.environment.vector import make_vector
from t2l.gains import Cell
from t2l.sim.arrays import to_numpy
from t2l.sim.batch import MUJOCO
from t2l.tasks import make_task

# a cell, action scales and actions: soft arms move far, and a humanoid's own gains let it fall
ARM = Cell(16, 24), (2.0, 1.0), {"kind": "joint_delta"}
WALKER = HAND = Cell(1, 1), (0.5, 0.5), {"kind": "joint_delta", "reference": "home"}
TASKS = {
    "lift_cube": ARM, "open_drawer": ARM, "reorient_cube": ARM, "track_velocity": WALKER,
    "in_hand_cube": HAND,
}  # fmt: skip
ROBOTS = 256, 2048, 4096, 8192
PERIODS = 50


def run(devices: Sequence[str] = (), robots: Sequence[int] = ROBOTS) -> pd.DataFrame:
    """One row a task, device and number of robots."""
    return pd.DataFrame(
        _row(name, device, n) for name in TASKS for device in devices or _here() for n in robots
    )


def _here() -> list[str]:
    import torch

    return [MUJOCO, *(["cuda"] if torch.cuda.is_available() else [])]


def _row(name: str, device: str, n: int) -> dict:
    file = Path(__file__).parents[1] / f"config/tasks/{name}.yaml"
    task = make_task(yaml.safe_load(file.read_text()))
    cell, scale, meaning = TASKS[name]
    environment = make_vector(
        task, cell, scale, n, actions=meaning, threads=os.cpu_count(), staggered=True, device=device
    ).environment
    environment.begin()
    batch, rng = environment.simulator.batch, np.random.default_rng(0)
    shape = (n, len(environment.action_names))
    actions = [environment.array(rng.uniform(-1, 1, shape)) for _ in range(10)]

    def closed_loop() -> None:
        for k in range(PERIODS):
            environment.advance(actions[k // 5 % len(actions)])

    def bare() -> None:
        for _ in range(PERIODS * environment.nstep):
            batch.step()

    closed_loop()
    ours_s, commands = _seconds(closed_loop, batch), batch.ctrl + 0.0
    # who fell lies about, and has more contacts than who is put back on his feet
    environment.begin()
    batch.ctrl[:] = commands
    bare_s = _seconds(bare, batch)
    steps = PERIODS * environment.nstep * n
    return {
        "task": name, "device": device, "robots": n, "steps/s": f"{steps / ours_s:,.0f}",
        "bare engine": f"{steps / bare_s:,.0f}", "ratio": f"{bare_s / ours_s:.2f}",
    }  # fmt: skip


def _seconds(do: Callable[[], None], batch) -> float:
    began = time.perf_counter()
    do()
    # a GPU is waited for
    to_numpy(batch.qpos)
    return time.perf_counter() - began


def main(arguments: Sequence[str]) -> pd.DataFrame:
    """The engines that are named, or those of this machine."""
    return run(arguments)
