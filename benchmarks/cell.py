"""One cell at paper scale, through Snakemake as a user runs it, and how training grows."""

import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
import pandas as pd

from benchmarks.overhead import copied_project
from benchmarks.scene import block_stack, demonstrations, paper
from t2l.actions import make_control
from t2l.demos.replay import replay
from t2l.gains import Cell
from t2l.policies import POLICIES, Episode
from t2l.policies.validation import split

TARGET = "results/paper/block_stack/nominal/{}/seed0/rollouts.parquet"


def run() -> pd.DataFrame:
    """Seconds and memory per stage; two cells against one on two cores; 100, 50, 25 demos."""
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        copied_project(folder)
        _snakemake(folder, ["results/paper/block_stack/demonstrations"], cores=2)
        one = _snakemake(folder, [TARGET.format("kp256_kd8")], cores=1)
        two = _snakemake(
            folder, [TARGET.format(name) for name in ("kp128_kd16", "kp512_kd16")], cores=2
        )
        stages = {
            path.parent.name: pd.read_csv(path, sep="\t").iloc[0]
            for path in Path(folder).glob("results/paper/benchmarks/*/*.tsv")
            if "kp256_kd8" in path.name or path.parent.name == "demonstrate"
        }
    for rule in ("demonstrate", "retarget", "train", "roll_out"):
        stage = stages[rule]
        rows.append((f"{rule}, 100 demonstrations", f"{stage.s:.0f} s", "", ""))
        rows.append((f"{rule}, peak memory", f"{stage.max_rss / 1024:.2f} GiB", "2 GiB", "below 1"))
    trained = stages["train"].s + stages["roll_out"].s
    rows.append(("train and roll_out of one cell", f"{trained:.0f} s", "120 s", "below 1"))
    rows.append(("one cell with retargeting and Snakemake, one core", f"{one:.0f} s", "120 s", ""))
    rows.append(("two cells on two cores", f"{two:.0f} s", f"{one:.0f} s for one", "near 1"))

    task = block_stack()
    control = make_control({"kind": "joint_target"}, Cell(256, 8), task.robot, task.model)
    section = {**paper()["training"], "epochs": 5}
    policy, fraction = POLICIES.find(section.pop("policy")), section.pop("validation_fraction")
    settings = policy.settings(**section)
    replays = replay(task, demonstrations(task, 100), control, 10, threads=2)
    episodes = [Episode(r.observation, np.column_stack([r.action, r.gripper])) for r in replays]
    seconds = {}
    for count in (100, 50, 25):
        start = time.perf_counter()
        policy.fit(*split(episodes[:count], fraction, 0), settings, seed=0)
        seconds[count] = time.perf_counter() - start
    for count in (50, 25):
        rows.append(
            (
                f"training 5 epochs on {count} demonstrations",
                f"{seconds[count]:.1f} s",
                f"{seconds[100]:.1f} s on 100",
                f"linear: {count / 100:g}",
            )
        )
    table = pd.DataFrame(rows, columns=["what", "measured", "baseline", "wanted ratio"])
    table.insert(
        3, "ratio", [_ratio(m, b) for m, b in zip(table.measured, table.baseline, strict=True)]
    )
    return table


def _ratio(measured: str, baseline: str) -> str:
    return f"{float(measured.split()[0]) / float(baseline.split()[0]):.2f}" if baseline else ""


def _snakemake(folder: str, targets: list[str], cores: int) -> float:
    command = [sys.executable, "-m", "snakemake", "--cores", str(cores)]
    start = time.perf_counter()
    subprocess.run(
        [*command, "--configfile", "config/studies/paper.yaml", "--", *targets],
        cwd=folder,
        check=True,
        stderr=subprocess.DEVNULL,
    )
    return time.perf_counter() - start
