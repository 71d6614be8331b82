"""One row a policy."""

import pandas as pd

from t2l.artefacts import write_table
from t2l.bc.rollout import COLUMNS
from t2l.bc.summary import CELL_COLUMNS, summarise


def test_a_row_a_policy_says_on_how_many_demonstrations_it_was_to_be_trained(tmp_path):
    """Of which fewer may have survived retargeting."""
    paths = {"replays": [], "losses": [], "rollouts": []}
    for kp in (32, 512):
        cell = {"kp": kp, "kd": 8, "seed": 1}
        replays = pd.DataFrame({"success": [True, True, False]})
        losses = pd.DataFrame(
            [
                cell | {"epoch": e, "validation_loss": 1 / e, "validation_mse_rad2": 0.1}
                for e in (2, 1)
            ]
        )
        rollouts = pd.DataFrame([dict.fromkeys(COLUMNS, 0.0) | cell | {"success": True}] * 4)
        for name, table in (("replays", replays), ("losses", losses), ("rollouts", rollouts)):
            paths[name].append(tmp_path / f"{name}_{kp}.parquet")
            write_table(table, paths[name][-1])
    _, cells = summarise(*paths.values(), {"kp32_kd8": 25, "kp512_kd8": 100})
    assert tuple(cells.columns) == CELL_COLUMNS
    assert cells.demonstrations.tolist() == [25, 100]
    assert cells.replays.tolist() == [3, 3]
    assert cells.validation_loss.tolist() == [0.5, 0.5]
