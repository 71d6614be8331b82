"""Whether a policy exists at the corners: the study `existence` on a machine that is lent.

`python -m benchmarks existence train FOLDER TASK [KP,KD …] [--device cuda] [--seconds S]` trains
the corners of a task, side by side on a GPU and one after another on the processor, and keeps each
policy, its training and, of a GPU, how it does there in as many fresh episodes as judge it. A
training that would not be evaluated once more within S seconds ends, with the best policy until
then. One that was killed goes on, also with another S.

`python -m benchmarks existence judge FOLDER` judges what a folder holds on the processor, and
brings docs/data/existence.csv and existence_curves.csv up to it. Rows of other policies stay.

`python -m benchmarks existence show FOLDER` draws a success and a failure of each policy beside it,
and all of them below each other in FOLDER/policies.png.
"""

import argparse
import json
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd

from benchmarks.scene import ROOT, configuration, task_file
from t2l.artefacts import write_table, write_text
from t2l.figures.frames import learned_frames
from t2l.gains import Cell
from t2l.plotting.style import write
from t2l.policies import checkpoint
from t2l.rl.algorithm import Trained
from t2l.rl.alone import COLUMNS, depends_on, judged, problem_of, settings_of, shown
from t2l.rl.side_by_side import Training, judge_side_by_side, learn_side_by_side
from t2l.rl.unfinished import Unfinished
from t2l.sim.batch import MUJOCO
from t2l.study.landscape.existence import at_corners
from t2l.version import library

TABLE, CURVES = (ROOT / f"docs/data/{name}.csv" for name in ("existence", "existence_curves"))
KEYS = ["task", "kp", "kd", "seed"]
ON_GPU = ["episodes_gpu", "successes_gpu"]
OF_CURVES = [*KEYS, "update", "steps", "seconds", "reward", "success", "failed", "jitter"]
DIGITS = 5  # format: of numbers in the tables
DPI = 100  # format: of pictures, points an inch


def main(arguments: Sequence[str]) -> pd.DataFrame:
    """What the command line asks for: a row a policy."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks existence")
    parser.add_argument("what", choices=["train", "judge", "show"])
    parser.add_argument("folder", type=Path, help="of policies")
    parser.add_argument("task", nargs="?", help="one of the study")
    parser.add_argument("cells", nargs="*", metavar="KP,KD", help="of its corners (default: all)")
    parser.add_argument(
        "--device", default=MUJOCO, help="of the simulations (default: %(default)s)"
    )
    parser.add_argument("--seconds", type=float, help="at most, about")
    parser.add_argument("--threads", type=int, default=1)
    parser.add_argument("--seed", type=int, default=1, help="number of the policies")
    parser.add_argument("--robots", type=int, help="in place of the study's")
    parser.add_argument("--updates", type=int, help="in place of the study's")
    asked = parser.parse_args(arguments)
    if asked.what != "train":
        return judge(asked.folder, asked.threads) if asked.what == "judge" else show(asked.folder)
    entries = _entries()
    if asked.task not in entries:
        parser.error(f"found {asked.task}; allowed: {', '.join(entries)}")
    known = {Cell(own["kp"], own["kd"]) for own in entries[asked.task]["action_scales"]}
    cells = [Cell(*map(float, cell.split(","))) for cell in asked.cells] or sorted(known, key=str)
    if unknown := [str(cell) for cell in cells if cell not in known]:
        parser.error(f"found {', '.join(unknown)}; allowed: {', '.join(map(str, known))}")
    trainings = [training(asked, entries[asked.task], cell) for cell in cells]
    return train(trainings, asked, configuration("studies/existence")["learning"]["episodes"])


def _entries() -> dict[str, dict[str, Any]]:
    """Of the study, by task."""
    tasks = configuration("studies/existence")["learning"]["tasks"]
    return {entry["task"]: entry for entry in tasks}


def training(asked: argparse.Namespace, entry: dict, cell: Cell) -> Training:
    """As `make learning` trains it, but for its number of robots and updates."""
    sizes = {"environments": asked.robots, "updates": asked.updates}
    entry = {**entry, **{name: size for name, size in sizes.items() if size}}
    problem, choice = problem_of(entry, task_file(entry["task"]), cell)
    section = configuration("studies/existence")["reinforcement_learning"]
    section = {key: value for key, value in section.items() if key != "horizon_s"}
    settings = settings_of(section, entry).of_policy(entry["task"], cell, asked.seed)
    path = asked.folder / f"{entry['task']}_{cell.name}_{asked.seed}"
    text = f"{library()} {depends_on(problem, choice, settings, asked.seed)}"
    return Training(
        problem, choice, settings, unfinished=Unfinished(path.with_name(f"{path.name}.pt"), text)
    )


def train(trainings: Sequence[Training], asked: argparse.Namespace, episodes: int) -> pd.DataFrame:
    """Train side by side on a GPU, one after another on the processor, and judge."""
    device = None if asked.device == MUJOCO else asked.device
    groups = [trainings] if device else [[one] for one in trainings]
    for group in groups:
        found = learn_side_by_side(
            [within(own, asked.seconds, len(groups)) for own in group], asked.threads, device
        )
        complete = [
            (own, one) for own, one in zip(group, found, strict=True) if isinstance(one, Trained)
        ]
        for own, one in zip(group, found, strict=True):
            if not isinstance(one, Trained):
                print(f"{own.problem.condition.name} {own.problem.cell}: {one}", flush=True)
        for own, one in complete:
            _keep(own, one, {"seed": asked.seed})
        if device and complete:
            policies = [one.policy for _, one in complete]
            there = judge_side_by_side([own for own, _ in complete], policies, 1, device, episodes)
            for (own, one), result in zip(complete, there, strict=True):
                counts = episodes, round(result.success * episodes)
                _keep(own, one, {"seed": asked.seed, **dict(zip(ON_GPU, counts, strict=True))})
        for own in group:
            own.unfinished.remove()
    return judge(asked.folder, asked.threads)


def within(own: Training, seconds: float | None, groups: int) -> Training:
    """A training with its share of a time, which goes on from what one without it kept."""
    limit_s = None if seconds is None else seconds / groups
    return replace(own, settings=replace(own.settings, limit_s=limit_s))


def _keep(own: Training, one: Trained, more: dict) -> None:
    """A policy, its training and what is known of it, beside each other."""
    path, cell = own.unfinished.path, own.problem.cell
    checkpoint.save(one.policy, path.with_suffix(".safetensors"))
    write_table(one.history, path.with_suffix(".parquet"))
    sizes = {"robots": own.settings.environments, "updates": own.settings.updates}
    known = {"task": own.problem.condition.name, "kp": cell.kp, "kd": cell.kd, **sizes, **more}
    write_text(json.dumps(known), path.with_suffix(".json"))


def kept(folder: Path) -> Iterator[tuple[Path, dict[str, Any], Training, Trained]]:
    """What a folder holds: file and content of what is known of a policy, its training, itself."""
    for path in sorted(folder.glob("*.json")):
        known = json.loads(path.read_text())
        asked = argparse.Namespace(
            folder=folder, seed=known["seed"], robots=known["robots"], updates=known["updates"]
        )
        own = training(asked, _entries()[known["task"]], Cell(known["kp"], known["kd"]))
        history = pd.read_parquet(path.with_suffix(".parquet"))
        one = Trained(checkpoint.load(path.with_suffix(".safetensors")), None, history)
        yield path, known, own, one


def judge(folder: Path, threads: int) -> pd.DataFrame:
    """Rows of the policies of a folder, each judged once, which the kept tables take in."""
    episodes = configuration("studies/existence")["learning"]["episodes"]
    rows, curves = [], []
    for path, known, own, one in kept(folder):
        if "judged" not in known:
            row = judged(own, one, known["seed"], threads, episodes)
            known["judged"] = row | {name: known.get(name) for name in ON_GPU}
            write_text(json.dumps(known), path)
            print(known["judged"], flush=True)
        rows.append(known["judged"])
        curves.append(one.history.assign(**{key: known[key] for key in KEYS})[OF_CURVES])
    cells = {
        task: [Cell(own["kp"], own["kd"]) for own in entry["action_scales"]]
        for task, entry in _entries().items()
    }
    table = pd.DataFrame(rows, columns=[*COLUMNS, *ON_GPU]).astype(dict.fromkeys(ON_GPU, float))
    table = at_corners(table, cells)
    _bring_up(TABLE, table)
    _bring_up(CURVES, pd.concat(curves, ignore_index=True))
    return table


def show(folder: Path) -> pd.DataFrame:
    """A picture of each policy, and one of all; a row each, with its file."""
    rows, pictures = [], []
    for path, known, own, one in kept(folder):
        episodes = shown(own.problem, own.choice, own.settings, one.policy)
        figure = learned_frames(own.problem.task, episodes, known["task"])
        picture = path.with_suffix(".png")
        write(figure, [picture], dpi=DPI)
        pictures.append(plt.imread(picture))
        rows.append({key: known[key] for key in KEYS} | {"picture": picture.name})
    plt.imsave(folder / "policies.png", np.concatenate(pictures))
    return pd.DataFrame(rows)


def _bring_up(path: Path, found: pd.DataFrame) -> None:
    """Put rows in place of those of the same policies."""
    if path.is_file():
        kept = pd.read_csv(path)
        again = kept.set_index(KEYS).index.isin(found.set_index(KEYS).index)
        found = pd.concat([kept[~again], found])
    found = found.sort_values(KEYS, kind="stable")
    write_text(found.to_csv(index=False, float_format=f"%.{DIGITS}g"), path)
