"""The real FR3's recordings explained ten times, each time with ten others held out.

`T2L_STUDY_DATA` names the folder with `fr3_gain_grid/`. What is held out is drawn anew each time
and reports the error, nothing else. What is made is kept in results/bench/holdouts, so that an
interrupted run goes on where it stopped.
"""

import json
import os
import subprocess
import sys
from collections import Counter
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from queue import SimpleQueue

import pandas as pd

from benchmarks import one_core
from benchmarks.hidden import code_key
from benchmarks.scene import ROOT
from t2l.diagnose.files import PARTIAL, PROPOSED
from t2l.identify.model import read_model
from t2l.seeds import generator

FOLDER = ROOT / "results/bench/holdouts"
CHOICES, HELD_OUT = 10, 10
PROCESSES = min(CHOICES, len(os.sched_getaffinity(0)))


def run() -> pd.DataFrame:
    """One row a choice of what is held out; how often each effect was adopted is printed above."""
    data = os.environ.get("T2L_STUDY_DATA")
    if not data:
        return pd.DataFrame({"skipped": ["T2L_STUDY_DATA does not name the folder of the data"]})
    logs = sorted((Path(data) / "fr3_gain_grid").glob("*.csv"))
    numbers = range(1, CHOICES + 1)
    ready = one_core.cores(SimpleQueue())
    with ThreadPoolExecutor(PROCESSES, initializer=one_core.take, initargs=(ready,)) as pool:
        found = list(pool.map(explained, [logs] * CHOICES, numbers))
    often = Counter(effect for each in found for effect in each["adopted"])
    print("\n".join(f"{effect}: {count} of {CHOICES}" for effect, count in often.most_common()))
    return pd.DataFrame([row(*pair) for pair in zip(numbers, found, strict=True)])


def explained(logs: Sequence[Path], number: int) -> dict:
    """The content of explanation.json with choice `number` held out, and the effects in the end.

    `partial` says whether these explain only a part.
    """
    held = set(generator(number, "holdouts").choice(len(logs), HELD_OUT, replace=False).tolist())
    out, made_by = FOLDER / str(number), FOLDER / f"{number}.key"
    if not made_by.exists() or made_by.read_text() != code_key():
        kept = [log for i, log in enumerate(logs) if i not in held]
        others = [log for i, log in enumerate(logs) if i in held]
        out.parent.mkdir(parents=True, exist_ok=True)
        command = [sys.executable, "-m", "t2l", "explain", *kept, "--holdout", *others]
        with open(f"{out}.log", "w") as log:
            subprocess.run([*command, "--out", out], check=True, stdout=log, stderr=log)
        made_by.write_text(code_key())
    # laws that were learned may have taken the place of names, but not in this file
    content = json.loads((out / "explanation.json").read_text())
    partial = out / PROPOSED / PARTIAL
    model = read_model(partial if partial.exists() else out / "model.yaml")
    return content | {"adopted": list(model.effects), "partial": partial.exists()}


def row(number: int, found: dict) -> dict:
    """Errors in mrad, of what was held out."""
    steps = found["steps"]
    before, after = (1e3 * step["test_rmse_q_rad"] for step in (steps[0], steps[-1]))
    return {
        "choice": number,
        "test before, mrad": before,
        "with known effects": after,
        "in the end": ", ".join(found["adopted"]),
        "explain a part only": "yes" if found["partial"] else "no",
        "verdict": found["verdict"],
    }
