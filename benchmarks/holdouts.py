"""The real FR3's recordings explained ten times, each time with ten others held out.

`T2L_STUDY_DATA` names the folder with `fr3_gain_grid/`. What is held out is drawn anew each time
and reports the error, nothing else. `python -m benchmarks holdouts [--processes N] [CHOICE …]`
takes some choices. Each has an equal share of the cores. What is made is kept in
results/bench/holdouts, so that an interrupted run goes on where it stopped.
"""

import argparse
import json
import os
import subprocess
import sys
import time
from collections import Counter
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from pathlib import Path
from queue import SimpleQueue

import pandas as pd

from benchmarks import one_core
from benchmarks.hidden import code_key
from benchmarks.scene import ROOT
from t2l.identify.model import read_model
from t2l.seeds import generator

FOLDER = ROOT / "results/bench/holdouts"
CHOICES, HELD_OUT = 10, 10
PROCESSES = min(CHOICES, len(os.sched_getaffinity(0)))


def main(arguments: Sequence[str]) -> pd.DataFrame:
    """What the command line asks for."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks holdouts", description=__doc__)
    numbers = range(1, CHOICES + 1)
    parser.add_argument(
        "choices", nargs="*", type=int, choices=numbers, metavar="CHOICE", help="(default: all)"
    )
    one_core.add_processes(parser, PROCESSES)
    given = parser.parse_args(arguments)
    return run(given.choices or numbers, given.processes)


def run(numbers: Sequence[int] = range(1, CHOICES + 1), processes: int = PROCESSES) -> pd.DataFrame:
    """One row a choice of what is held out; how often each effect was adopted is printed above."""
    data = os.environ.get("T2L_STUDY_DATA")
    if not data:
        return pd.DataFrame({"skipped": ["T2L_STUDY_DATA does not name the folder of the data"]})
    logs = sorted((Path(data) / "fr3_gain_grid").glob("*.csv"))
    ready = one_core.shares(SimpleQueue(), processes)
    with ThreadPoolExecutor(processes, initializer=one_core.take, initargs=(ready,)) as pool:
        each = list(pool.map(partial(explained, logs), numbers))
    found = {number: one for number, one in zip(numbers, each, strict=True) if one}
    often = Counter(effect for one in found.values() for effect in one["adopted"])
    print("\n".join(f"{effect}: {count} of {len(found)}" for effect, count in often.most_common()))
    table = pd.DataFrame([row(*pair) for pair in found.items()])
    table.to_csv(FOLDER / "table.csv", index=False)
    return table


def explained(logs: Sequence[Path], number: int) -> dict | None:
    """What came of choice `number`: the content of explanation.json, and what the model has.

    None if it failed, which a line says.
    """
    held = set(generator(number, "holdouts").choice(len(logs), HELD_OUT, replace=False).tolist())
    out, made_by = FOLDER / str(number), FOLDER / f"{number}.key"
    if not made_by.exists() or made_by.read_text() != code_key():
        kept = [log for i, log in enumerate(logs) if i not in held]
        others = [log for i, log in enumerate(logs) if i in held]
        out.parent.mkdir(parents=True, exist_ok=True)
        command = [sys.executable, "-m", "t2l", "explain", *kept, "--holdout", *others]
        began = time.perf_counter()
        with open(f"{out}.log", "a") as log:
            env = os.environ | {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
            done = subprocess.run([*command, "--out", out], env=env, stdout=log, stderr=log)
        if done.returncode:
            print(f"choice {number} failed, see {out}.log", flush=True)
            return None
        made_by.write_text(code_key())
        print(f"choice {number}: {time.perf_counter() - began:.0f} s", flush=True)
    model = read_model(out / "model.yaml")
    return json.loads((out / "explanation.json").read_text()) | {
        "adopted": [*model.effects, *(curve.law.name for curve in model.learned)],
        "curves": [curve.law.words for curve in model.learned],
    }


def row(number: int, found: dict) -> dict:
    """Errors in mrad, of what was held out."""
    steps = found["steps"]
    before, after = (1e3 * step["test_rmse_q_rad"] for step in (steps[0], steps[-1]))
    return {
        "choice": number,
        "test before, mrad": before,
        "after": after,
        "adopted": ", ".join(found["adopted"]),
        "curves": "; ".join(found["curves"]),
        "verdict": found["verdict"],
    }
