"""What Snakemake adds: seconds per job and for a run with nothing to do."""

import re
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import pandas as pd

from benchmarks.scene import ROOT

WITHOUT_TORCH = ("fidelity", "summarise", "statistics", "success_figure", "fidelity_figure")


def run() -> pd.DataFrame:
    """From the smoke configuration: every job's process against the work it logged."""
    with tempfile.TemporaryDirectory() as folder:
        copied_project(folder)
        total = _smoke(folder)
        nothing = _smoke(folder)
        python = _seconds([sys.executable, "-c", "pass"])
        jobs = _jobs(Path(folder) / "results/smoke")
    rows = [
        ("smoke configuration, all targets", f"{total:.0f} s", "180 s", total / 180),
        ("a run with nothing to do", f"{nothing:.1f} s", f"{python:.2f} s bare Python", None),
    ]
    for rule, part in jobs.groupby("rule"):
        start = part.start_s.mean()
        wanted = "2 s" if rule.split("/")[0] in WITHOUT_TORCH else ""
        ratio = start / 2 if wanted else None
        rows.append((f"{rule}: start and exit around its work", f"{start:.2f} s", wanted, ratio))
    between = (total - nothing - jobs.process_s.sum() / 2) / len(jobs)
    rows.append(("scheduling between jobs, a job (two at a time)", f"{between:.2f} s", "", None))
    table = pd.DataFrame(rows, columns=["what", "measured", "bound or baseline", "ratio"])
    table["ratio"] = ["" if pd.isna(r) else f"{r:.2f}" for r in table.ratio]
    return table


def copied_project(folder: str) -> None:
    """A copy of the workflow to run in."""
    for name in ("workflow", "config", "profiles"):
        shutil.copytree(ROOT / name, Path(folder) / name)
    shutil.copy(ROOT / "Snakefile", folder)


def _smoke(folder: str) -> float:
    command = [sys.executable, "-m", "snakemake", "--cores", "2"]
    return _seconds([*command, "--configfile", "config/studies/smoke.yaml", "--", "all"], folder)


def _seconds(command: list[str], folder: str | None = None) -> float:
    start = time.perf_counter()
    subprocess.run(command, cwd=folder, check=True, stderr=subprocess.DEVNULL)
    return time.perf_counter() - start


def _jobs(results: Path) -> pd.DataFrame:
    """One row per job: seconds of its process, and of these before the work began."""
    rows = []
    for log in results.glob("logs/**/*.log"):
        name = log.relative_to(results / "logs").with_suffix(".tsv")
        process_s = pd.read_csv(results / "benchmarks" / name, sep="\t").s[0]
        work_s = float(re.search(r"done in ([0-9.]+) s", log.read_text())[1])
        rule = name.parts[0].removesuffix(".tsv")
        rows.append((rule, process_s, process_s - work_s))
    return pd.DataFrame(rows, columns=["rule", "process_s", "start_s"])
