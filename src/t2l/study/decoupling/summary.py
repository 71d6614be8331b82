"""What trainings came to: one row a pairing and seed."""

from collections.abc import Mapping
from typing import TYPE_CHECKING

from t2l.study.decoupling.pairing import Pairing

if TYPE_CHECKING:
    import pandas as pd

COLUMNS = (
    "pairing", "kp", "kd", "seed", "stiffness_n_m", "passive_n_m", "drift", "swing", "success",
)  # fmt: skip
CHOOSING = 2  # statistics: seeds, counted from 1, that choose a weight and tell nothing else
STEADY = 0.1  # statistics: the most drift of Δx, so that K_eff is known to a tenth
HELD = 0.5  # definition: a pose that is held more often than not


def holding(trainings: "pd.DataFrame") -> "pd.Series":
    """Of which trainings K_eff is a stiffness: the policy holds its pose, and yields steadily.

    It holds the pose if it ends at least half of its episodes within the task's tolerance. A tool
    that still drifts has no steady displacement, which K_eff is defined by.

    Args:
        trainings: columns `drift` and `success`; of a success that is not known none holds.
    """
    return (trainings.success >= HELD) & (trainings.drift <= STEADY)


def chosen(trainings: "pd.DataFrame") -> "pd.DataFrame":
    """Of each gain the trainings of one weight, where several were tried.

    The first seeds choose: the weight of which most hold the pose steadily, of equals the one that
    holds it most often, then the one that drifts least. The other seeds are what is told.

    Args:
        trainings: columns `COLUMNS`.
    """
    if trainings.groupby("kp").pairing.nunique().max() == 1:
        return trainings
    first = trainings[trainings.seed <= CHOOSING]
    of_pairing = first.assign(holds=holding(first)).groupby(["kp", "pairing"], as_index=False)
    ranked = of_pairing.agg(holds=("holds", "mean"), success=("success", "mean"),
                            drift=("drift", "median"))  # fmt: skip
    ranked = ranked.sort_values(["holds", "success", "drift"], ascending=[False, False, True])
    best = ranked.drop_duplicates("kp").pairing
    return trainings[trainings.pairing.isin(best) & (trainings.seed > CHOOSING)]


def summarise(tables: Mapping[tuple[Pairing, int], "pd.DataFrame"]) -> "pd.DataFrame":
    """One row a training, as it was evaluated last: medians over directions; columns `COLUMNS`.

    Args:
        tables: of `training.train`, by pairing and seed.
    """
    import pandas as pd

    rows = []
    for (pairing, seed), table in tables.items():
        last = table[table["update"] == table["update"].max()]
        medians = last[list(COLUMNS[4:])].median()
        rows.append(
            {"pairing": pairing.name, "kp": pairing.kp, "kd": pairing.kd, "seed": seed, **medians}
        )
    return pd.DataFrame(rows, columns=COLUMNS)
