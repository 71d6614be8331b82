"""What is kept of demonstrations and starts drawn anew.

`python -m benchmarks collections [RESULTS]` writes docs/data/collections.csv, one row a policy, of
what config/studies/collections.yaml and collections_900.yaml left in results/. Only variants of
which a collection has all cells are taken.
"""

from collections.abc import Sequence
from pathlib import Path

import pandas as pd

from benchmarks.scene import ROOT
from t2l.artefacts import read_table, write_text
from t2l.bc.collections import collection

TABLE = ROOT / "docs/data/collections.csv"
COLUMNS = [
    "variant", "collection", "kp", "kd", "seed", "success", "rollouts", "validation_loss",
    "validation_mse_rad2",
]  # fmt: skip
# studies, and how many cells each has
STUDIES = {"collections": 16, "collections_900": 8}


def main(arguments: Sequence[str]) -> pd.DataFrame:
    """Gather the tables of all variants and collections; how many of these each variant has."""
    results, rows = Path(*arguments or ["results"]), []
    for study, cells in STUDIES.items():
        for number in range(100):
            folder = Path(results, study, collection("block_stack", number))
            for path in sorted(folder.glob("*/cells.parquet")):
                variant = path.parent.name if study == "collections" else "demonstrations_900"
                table = read_table(path, tuple(COLUMNS[2:]))
                if len(table) >= cells:
                    rows.append(table.assign(variant=variant, collection=number))
    table = pd.concat(rows)[COLUMNS].sort_values(COLUMNS[:5])
    table = table.round({"validation_loss": 6, "validation_mse_rad2": 8})
    write_text(table.to_csv(index=False), TABLE)
    return table.groupby("variant").collection.nunique().reset_index()
