"""Whether advice on gains is right, in worlds whose best gains are known by trainings.

`python -m benchmarks planted_worlds train {development,test} [--processes N]` trains and tries the
policies of one half of the worlds, for docs/data/planted_worlds.csv (a row a policy and stage).
`python -m benchmarks planted_worlds judge {development,test}` says by the rule of
`benchmarks.planted.verdict` what advice is worth there, from that table, for planted_advice.csv (a
row a world and what is known of it) and planted_pairs.csv (a row a world, what is known and a
stated chance). The test half is to be judged once.
"""

import argparse
import time
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path

import pandas as pd

from benchmarks.planted.cloned import POLICIES, trained, tried
from benchmarks.planted.shown import SHOWN, demonstrations, worlds
from benchmarks.planted.world import World
from benchmarks.scene import ROOT
from t2l.artefacts import write_text

DATA = ROOT / "docs/data"
TRAINED, ADVISED, PAIRS = "planted_worlds.csv", "planted_advice.csv", "planted_pairs.csv"
SEED = 54
HALVES = ("development", "test")


def half(name: str, seed: int = SEED) -> list[World]:
    """The worlds of one half."""
    return [world for world in worlds(seed) if world.development == (name == HALVES[0])]


def main(arguments: Sequence[str]) -> pd.DataFrame:
    """See the module."""
    parser = argparse.ArgumentParser("planted_worlds")
    parser.add_argument("what", choices=["train", "judge"])
    parser.add_argument("half", choices=HALVES)
    parser.add_argument("--out", type=Path, default=DATA)
    parser.add_argument("--processes", type=int, default=2)
    parser.add_argument("--policies", type=int, default=POLICIES)
    parser.add_argument("--epochs", type=int, default=50)
    parser.add_argument("--shown", type=int, default=SHOWN)
    parser.add_argument("--only", nargs="*", help="names of worlds")
    asked = parser.parse_args(arguments)
    some = [world for world in half(asked.half) if asked.only is None or world.name in asked.only]
    return (judge if asked.what == "judge" else train)(some, asked)


def judge(some: Sequence[World], asked: argparse.Namespace) -> pd.DataFrame:
    """Judge advice by what was trained."""
    from benchmarks.planted.verdict import judged

    table = pd.read_csv(asked.out / TRAINED)
    rows, pairs = [], []
    with ProcessPoolExecutor(asked.processes, get_context("spawn")) as pool:
        for found, own in pool.map(judged, some, [table] * len(some)):
            rows += found
            pairs += own
            print(found, flush=True)
    for name, one in ((ADVISED, rows), (PAIRS, pairs)):
        _keep(asked.out / name, asked.half, pd.DataFrame(one).round(4))
    return pd.DataFrame(rows).round(2)


def _keep(path: Path, name: str, found: pd.DataFrame) -> None:
    """Bring the rows of a half's worlds up to what is found."""
    found = found.assign(half=name)
    kept = pd.read_csv(path) if path.exists() else found.iloc[:0]
    again = (kept.half == name) & kept.world.isin(found.world)
    both = pd.concat([kept[~again], found]).sort_values("half", kind="stable")
    write_text(both.to_csv(index=False), path)


def train(some: Sequence[World], asked: argparse.Namespace) -> pd.DataFrame:
    """Train, try, and write a row a policy and stage."""
    began = time.monotonic()
    with ProcessPoolExecutor(asked.processes, get_context("spawn")) as pool:
        shown = list(pool.map(demonstrations, some, [asked.shown] * len(some)))
    print(f"{time.monotonic() - began:.0f} s: shown", flush=True)
    policies = _trained(some, shown, asked)
    print(f"{time.monotonic() - began:.0f} s: {len(policies)} policies", flush=True)
    rows = []
    for found in tried(some, policies, asked.processes):
        rows.append(found)
        _keep(asked.out / TRAINED, asked.half, pd.concat(rows))
        print(f"{time.monotonic() - began:.0f} s: {len(found)} tried", flush=True)
    table = pd.concat(rows)
    means = table.groupby(["world", "kp", "kd"])[["successes", "rollouts"]].sum()
    return (means.successes / means.rollouts).unstack(["kd", "kp"]).T.reset_index().round(2)


def _trained(some, shown, asked) -> list:
    """By robot, those of one robot on one of the cards."""
    import torch

    cards = max(1, torch.cuda.device_count())
    robots = list(dict.fromkeys(world.robot for world in some))
    jobs = [[i for i, world in enumerate(some) if world.robot == robot] for robot in robots]
    settings = {"policies": asked.policies, "epochs": asked.epochs}
    context = get_context("spawn")
    with ProcessPoolExecutor(cards, context, _on_card, (context.Value("i", 0),)) as pool:
        futures = [
            pool.submit(trained, own, [some[i] for i in own], [shown[i] for i in own], **settings)
            for own in jobs
        ]
        return [one for future in futures for one in future.result()]


def _on_card(counter) -> None:
    """Each process takes a card of its own, if there are some."""
    import os

    with counter.get_lock():
        os.environ["CUDA_VISIBLE_DEVICES"] = str(counter.value)
        counter.value += 1
