"""The time of a diagnosis beside that of an earlier revision, in one run.

`python -m benchmarks earlier --checkout FOLDER` compares with the checkout in FOLDER, made by
`git worktree add FOLDER REVISION`. Both diagnose the same recordings on one core: with the effects
that both know, and with all that each knows. Runs of the two are interleaved; seconds are the
processor's, of the diagnosis alone.
"""

import argparse
import os
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pandas as pd

from benchmarks import one_core, recordings
from benchmarks.scene import ROOT

REPEATS = 3
LOGS = {
    "the arm with friction, one log of 10 s": ("friction", "two_joint_arm"),
    "the FR3 with friction, one log of 10 s": ("friction", "fr3"),
    "the arm with play, one log of 10 s": ("play", "two_joint_arm"),
}


def main(arguments: Sequence[str]) -> pd.DataFrame:
    """What the command line asks for."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks earlier", description=__doc__)
    parser.add_argument(
        "--checkout", type=Path, metavar="FOLDER", required=True, help="of the earlier revision"
    )
    folder = parser.parse_args(arguments).checkout.resolve()
    os.sched_setaffinity(0, one_core.first())
    known = [set(names(root)) for root in (folder, ROOT)]
    both = sorted(known[0] & known[1])
    rows = []
    for what, single in LOGS.items():
        log = recordings.single(*single)
        for tried, which in (
            (f"the {len(both)} that both know", [both, both]),
            (f"all: {len(known[0])} and {len(known[1])}", [[], []]),
        ):
            checked = list(zip((folder, ROOT), which, strict=True))
            seconds = np.array(
                [[seconds_of(root, log, one) for root, one in checked] for _ in range(REPEATS)]
            )
            ratios = seconds[:, 1] / seconds[:, 0]
            before, today = np.median(seconds, axis=0)
            rows.append(
                {
                    "diagnosed": what,
                    "effects tried": tried,
                    f"{revision(folder)}, s": f"{before:.1f}",
                    f"{revision(ROOT)}, s": f"{today:.1f}",
                    "ratio": f"{np.median(ratios):.2f} ({ratios.min():.2f} to {ratios.max():.2f})",
                }
            )
            print(" | ".join(rows[-1].values()), flush=True)
    return pd.DataFrame(rows)


def revision(root: Path) -> str:
    """The short hash and the day of a checkout's commit."""
    line = ["git", "-C", str(root), "log", "-1", "--format=%h of %ad", "--date=short"]
    return subprocess.run(line, check=True, capture_output=True, text=True).stdout.strip()


def names(root: Path) -> list[str]:
    """Effects that a checkout knows."""
    return said(root, "names").split()


def seconds_of(root: Path, log: Path, effects: Sequence[str]) -> float:
    """Of the diagnosis of a recording by a checkout, with some effects or all."""
    return float(said(root, str(log), *effects))


def said(root: Path, *arguments: str) -> str:
    """What `benchmarks.timed_diagnosis` of here prints last when it imports a checkout's t2l."""
    env = os.environ | {"PYTHONPATH": str(root / "src"), "OMP_NUM_THREADS": "1"}
    # as a module: beside a script its folder would come first, whose collections.py is not Python's
    line = [sys.executable, "-m", "benchmarks.timed_diagnosis", *arguments]
    done = subprocess.run(line, env=env, cwd=ROOT, check=True, capture_output=True, text=True)
    return done.stdout.strip().splitlines()[-1]
