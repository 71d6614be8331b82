"""Write cases: `python -m benchmarks.hidden_effects OUT [CASE ...]`, of a drawn set if asked."""

import argparse
import sys
from concurrent.futures import ProcessPoolExecutor, as_completed
from pathlib import Path
from time import perf_counter

import pandas as pd

from benchmarks.hidden_effects.cases import VISIBLE, Case, cases, is_complete, make, visibility
from benchmarks.hidden_effects.drawn_robots import cases_on_robots

PROCESSES = 2


def write_case(case: Case, out: Path) -> float:
    """Write what of a case is not there yet; return the seconds it took."""
    began = perf_counter()
    folder = out / case.name
    if not is_complete(case, folder):
        make(case, folder)
    if case.hidden and not (folder / "visibility.csv").exists():
        pd.DataFrame(visibility(case, folder)).to_csv(folder / "visibility.csv", index=False)
    return perf_counter() - began


def main(out: Path, names: list[str], drawn: list[Case]) -> None:
    """Write those that are named, or all of them, and print how visible their effects are."""
    table = {case.name: case for case in drawn}
    unknown = set(names) - set(table)
    if unknown:
        sys.exit(f"no case {', '.join(sorted(unknown))}; there are {', '.join(table)}")
    chosen = [table[name] for name in names or table]
    failed = []
    with ProcessPoolExecutor(PROCESSES) as pool:
        jobs = {pool.submit(write_case, case, out): case for case in chosen}
        for job in as_completed(jobs):
            case = jobs[job]
            try:
                print(f"{case.name}: {job.result():.1f} s", flush=True)
            except FloatingPointError as error:  # the others are worth having
                print(f"{case.name}: not written: {error}", flush=True)
                failed.append(case.name)

    files = [out / c.name / "visibility.csv" for c in chosen if c.hidden and c.name not in failed]
    if files:
        seen = pd.concat([pd.read_csv(file) for file in files])
        print(seen.round(3).to_markdown(index=False))
        hardly = seen[seen["ratio"] < VISIBLE]
        if len(hardly):
            sys.exit(f"hardly visible: {', '.join(hardly['case'])}")
    if failed:
        sys.exit(f"not written: {', '.join(failed)}")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("out", type=Path)
    parser.add_argument("names", nargs="*", metavar="CASE")
    seeds = parser.add_mutually_exclusive_group()
    seeds.add_argument("--test-seed", type=int, metavar="N", help="of a test set drawn anew")
    seeds.add_argument("--robots", type=int, metavar="N", help="seed of a set over more robots")
    asked = parser.parse_args()
    drawn = cases(asked.test_seed) if asked.robots is None else cases_on_robots(asked.robots)
    main(asked.out, asked.names, drawn)
