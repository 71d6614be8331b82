"""What a checkout computes, to be held against another: a move of code must change no number.

    python -m benchmarks.reference results/reference            # in the checkout before
    python -m benchmarks.reference results/reference --against ../before/results/reference

The smoke configuration with both chains, the diagnosis of a dozen recordings with hidden effects
and, where `T2L_STUDY_DATA` names a folder with them, the comparison of the FR3's 49 recordings. It
goes through the commands that people type, so it outlives every move of the code.
"""

import argparse
import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import yaml

ROOT = Path(__file__).parents[1]

# one of every kind of effect that acts in a way of its own
DIAGNOSED = (
    "armature_1_pendulum",
    "coulomb_friction_2_pendulum",
    "command_delay_1_pendulum",
    "joint_flexibility_1_pendulum",
    "viscous_friction_3_two_joint_arm",
    "torque_constant_3_two_joint_arm",
    "cogging_1_pendulum",
    "payload_3_two_joint_arm",
    "torque_saturation_1_pendulum",
    "controller_gains_3_two_joint_arm",
    "low_rate_loop_3_two_joint_arm",
    "clean_arm_stiff",
)
# how long something took, which no two runs share
TIMED = {"seconds"}


def compute(out: Path, smoke: Path) -> None:
    """Everything, into `out`; what is there is kept."""
    out.mkdir(parents=True, exist_ok=True)
    snakemake = [sys.executable, "-m", "snakemake", "--cores", "2", "--configfile", str(smoke)]
    subprocess.run([*snakemake, "--", "all"], cwd=ROOT, check=True)
    if not (out / "smoke").exists():
        (out / "smoke").symlink_to(ROOT / "results" / "smoke")
    from benchmarks.hidden_effects.cases import cases, make

    chosen = {case.name: case for case in cases()}
    for name in DIAGNOSED:
        folder = out / "cases" / name
        if not (folder / "truth.yaml").exists():
            make(chosen[name], folder)
        if not (out / "diagnosed" / name / "diagnosis.json").exists():
            _t2l("diagnose", folder / "train", "--holdout", folder / "holdout",
                 "--out", out / "diagnosed" / name)  # fmt: skip
    data = os.environ.get("T2L_STUDY_DATA")
    if data and not (out / "compared" / "comparison.json").exists():
        _t2l("compare", Path(data) / "fr3_gain_grid", "--out", out / "compared")


def _t2l(*arguments: Any) -> None:
    command = [sys.executable, "-m", "t2l", *map(str, arguments)]
    subprocess.run(command, cwd=ROOT, check=True)


def differences(out: Path, other: Path) -> list[str]:
    """Files that two references do not share, or whose numbers differ in any digit."""
    ours, theirs = (_files(folder) for folder in (out, other))
    found = [f"only in one: {name}" for name in sorted(ours.keys() ^ theirs.keys())]
    for name in sorted(ours.keys() & theirs.keys()):
        if not _equal(_content(ours[name]), _content(theirs[name])):
            found.append(f"differs: {name}")
    return found


def _files(folder: Path) -> dict[str, Path]:
    """What holds numbers: pictures carry dates, journals the names of processes."""
    kinds = {".parquet", ".csv", ".json", ".yaml", ".npz", ".md", ".tex"}
    return {
        str(path.relative_to(folder)): path
        for part in ("smoke", "diagnosed", "compared")
        for path in sorted((folder / part).rglob("*"))
        if path.suffix in kinds and not {"logs", "benchmarks"} & set(path.parts)
    }


def _content(path: Path) -> Any:
    match path.suffix:
        case ".parquet":
            table = pd.read_parquet(path)
            return table[[name for name in table if name not in TIMED]]
        case ".npz":
            with np.load(path) as arrays:
                return {name: arrays[name] for name in arrays.files}
        case ".json":
            return json.loads(path.read_text())
        case ".yaml":
            return yaml.safe_load(path.read_text())
        case ".csv":
            table = pd.read_csv(path)
            return table[[name for name in table if name not in TIMED]]
    return path.read_text()


def _equal(one: Any, other: Any) -> bool:
    if isinstance(one, pd.DataFrame) and isinstance(other, pd.DataFrame):
        return one.equals(other)
    if isinstance(one, dict) and isinstance(other, dict):
        return one.keys() == other.keys() and all(_equal(one[k], other[k]) for k in one)
    if isinstance(one, list | np.ndarray) and isinstance(other, list | np.ndarray):
        return len(one) == len(other) and all(map(_equal, one, other))
    both_nan = one != one and other != other
    return both_nan or one == other


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("out", type=Path)
    parser.add_argument("--smoke", type=Path, default=ROOT / "config/studies/smoke.yaml")
    parser.add_argument("--against", type=Path)
    given = parser.parse_args()
    compute(given.out.resolve(), given.smoke)
    if given.against:
        found = differences(given.out.resolve(), given.against.resolve())
        print("\n".join(found) or "no number differs")
        sys.exit(bool(found))
