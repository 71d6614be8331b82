"""What trainings came to: one row a pairing and seed."""

from collections.abc import Mapping
from typing import TYPE_CHECKING

from t2l.decoupling.pairing import Pairing

if TYPE_CHECKING:
    import pandas as pd

COLUMNS = (
    "pairing", "kp", "kd", "seed", "stiffness_n_m", "passive_n_m", "drift", "success",
)  # fmt: skip
AT_REST = 0.1  # statistics: of Δx in the last half second, so that K_eff is known to a tenth


def holding(trainings: "pd.DataFrame") -> "pd.Series":
    """Of which trainings K_eff is a stiffness: the policy holds its pose, and rests when pushed.

    It holds the pose if it ever ends an episode within the task's tolerance. A tool that still
    drifts has no steady displacement, which K_eff is defined by.

    Args:
        trainings: columns `drift` and `success`.
    """
    return (trainings.success > 0) & (trainings.drift <= AT_REST)


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
