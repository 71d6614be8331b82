"""What is kept of demonstrations and starts drawn anew.

`python -m benchmarks collections [RESULTS]` brings collections.csv and end_to_end.csv of docs/data,
one row a policy, up to what the studies collections, collections_900, collections_tasks and
end_to_end left in results/. Only collections that have all cells are taken. What is kept of
variants that are not there stays. end_to_end_operator.csv has the operator's attempts, a row a
collection and cell. collections_failures.csv says how rollouts of the nominal of each other task
failed, a row a collection, cell and kind of failure.
"""

from collections.abc import Mapping, Sequence
from pathlib import Path

import pandas as pd

from benchmarks.scene import ROOT
from t2l.artefacts import read_table, write_text
from t2l.bc.collections import collection
from t2l.demos.collect import TABLE_COLUMNS
from t2l.study.cloning.claims import ANEW_TASKS, OPERATED, OPERATED_TASK, TASK

DATA = ROOT / "docs/data"
COLUMNS = [
    "task", "variant", "collection", "kp", "kd", "seed", "success", "rollouts", "validation_loss",
    "validation_mse_rad2",
]  # fmt: skip
# by name of a file: studies, how many cells each has, and tasks
KEPT: Mapping[str, Sequence[tuple[str, int, Sequence[str]]]] = {
    "collections": (
        ("collections", 16, [TASK]),
        ("collections_900", 8, [TASK]),
        ("collections_tasks", 16, ANEW_TASKS),
    ),
    "end_to_end": (("end_to_end", 4, [OPERATED_TASK]),),
}


def main(arguments: Sequence[str]) -> pd.DataFrame:
    """Bring what is kept up to what is found; how many collections of each variant were found."""
    results, all_found = Path(*arguments or ["results"]), []
    for name, studies in KEPT.items():
        found = gather(results, studies)
        if found.empty:
            continue
        path = DATA / f"{name}.csv"
        table = merged(pd.read_csv(path), found)
        write_text(table.to_csv(index=False), path)
        all_found.append(found)
    if not (tried := attempts(results)).empty:
        write_text(tried.to_csv(index=False), DATA / "end_to_end_operator.csv")
    if not (kinds := failures(results)).empty:
        write_text(kinds.to_csv(index=False), DATA / "collections_failures.csv")
    if not all_found:
        raise SystemExit(f"{results} has no collections; make them with one of {[*KEPT]}")
    found = pd.concat(all_found)
    return found.groupby(["task", "variant"]).collection.nunique().reset_index()


def gather(results: Path, studies: Sequence[tuple[str, int, Sequence[str]]]) -> pd.DataFrame:
    """One row a policy, columns `COLUMNS`, of all collections of some studies that are whole."""
    rows = []
    for study, cells, tasks in studies:
        for task in tasks:
            for number in range(100):
                folder = Path(results, study, collection(task, number))
                for path in sorted(folder.glob("*/cells.parquet")):
                    table = read_table(path, tuple(COLUMNS[3:]))
                    if len(table[["kp", "kd"]].drop_duplicates()) >= cells:
                        apart = study == "collections_900"
                        variant = "demonstrations_900" if apart else path.parent.name
                        rows.append(table.assign(task=task, variant=variant, collection=number))
    table = pd.concat(rows) if rows else pd.DataFrame(columns=COLUMNS)
    return table[COLUMNS].round({"validation_loss": 6, "validation_mse_rad2": 8})


def attempts(results: Path) -> pd.DataFrame:
    """How an operator did in each collection and cell; times are of attempts that succeeded."""
    rows = []
    for number in range(100):
        folder = results / "end_to_end" / collection(OPERATED_TASK, number) / OPERATED
        for path in sorted(folder.glob("*/replays.parquet")):
            table = read_table(path, TABLE_COLUMNS)
            times = table.time_s[table.success]
            rows.append(
                {
                    "collection": number,
                    "kp": table.kp.iloc[0],
                    "kd": table.kd.iloc[0],
                    "attempts": len(table),
                    "successes": int(table.success.sum()),
                    "time_s": times.mean(),
                    "time_std_s": times.std(),
                    "crossover_rad_s": table.crossover_rad_s.iloc[0],
                }
            )
    return pd.DataFrame(rows).round(2)


def failures(results: Path) -> pd.DataFrame:
    """How many rollouts of a cell failed in a way; a success is none."""
    rows = []
    for task in ANEW_TASKS:
        for number in range(100):
            folder = results / "collections_tasks" / collection(task, number)
            for path in sorted(folder.glob("nominal/rollouts.parquet")):
                table = read_table(path, ("kp", "kd", "failure")).astype({"kp": int, "kd": int})
                found = table[["kp", "kd", "failure"]].value_counts(sort=False).reset_index()
                rows.append(found.assign(task=task, collection=number))
    columns = ["task", "collection", "kp", "kd", "failure", "count"]
    return pd.concat(rows)[columns] if rows else pd.DataFrame(columns=columns)


def merged(kept: pd.DataFrame, found: pd.DataFrame) -> pd.DataFrame:
    """What is found, and what is kept of other tasks and variants."""
    both = ["task", "variant"]
    again = kept.set_index(both).index.isin(found.set_index(both).index)
    return pd.concat([kept[~again], found]).sort_values(COLUMNS[:6], ignore_index=True)
