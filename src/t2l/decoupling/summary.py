"""What trainings came to: one row a pairing and seed."""

from collections.abc import Mapping
from typing import TYPE_CHECKING

from t2l.decoupling.pairing import Pairing

if TYPE_CHECKING:
    import pandas as pd

COLUMNS = (
    "pairing", "kp", "kd", "seed", "stiffness_n_m", "passive_n_m", "drift", "success",
)  # fmt: skip


def summarise(tables: Mapping[tuple[Pairing, int], "pd.DataFrame"]) -> "pd.DataFrame":
    """One row a training, as it was evaluated last: medians over directions; columns `COLUMNS`.

    Args:
        tables: of `t2l.decoupling.training.train`, by pairing and seed.
    """
    import pandas as pd

    rows = []
    for (pairing, seed), table in tables.items():
        last = table[table["update"] == table["update"].max()]
        medians = last[["stiffness_n_m", "passive_n_m", "drift", "success"]].median()
        rows.append(
            {"pairing": pairing.name, "kp": pairing.kp, "kd": pairing.kd, "seed": seed, **medians}
        )
    return pd.DataFrame(rows, columns=COLUMNS)
