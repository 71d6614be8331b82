import numpy as np
import pandas as pd

from t2l.stats.learning import learning_table, printable, printable_trials, trials_table


def test_a_policy_is_a_row_with_the_interval_of_its_own_share():
    policies = pd.DataFrame(
        {
            "task": "lift_cube", "kp": [512.0, 16.0], "kd": 24.0, "seed": 1, "episodes": 100,
            "successes": [99, 50], "failed": [0.0, 0.3], "jitter": 0.0,
            "steps": 1_000_000, "seconds": 600.0,
        }
    )  # fmt: skip
    table = learning_table(policies)
    assert table.kp.tolist() == [16.0, 512.0]
    # Wilson's of 50 of 100
    np.testing.assert_allclose(table.success_low[0], 0.4038, atol=1e-4)
    np.testing.assert_allclose(table.success_high[0], 0.5962, atol=1e-4)
    assert table.exists.tolist() == [False, True]
    printed = printable(table)
    assert printed.Success.tolist() == ["50.0 % (40 to 60)", "99.0 % (95 to 100)"]
    assert printed["Ended early"].tolist() == ["30.0 %", "0.0 %"]
    assert printed["At least 99 %"].tolist() == ["no", "yes"]


def test_trials_that_were_ended_did_not_pass():
    trials = pd.DataFrame(
        {
            "task": "lift_cube", "kp": 16.0, "kd": 24.0, "number": range(4),
            "state": ["complete", "complete", "complete", "pruned"],
            "success": [0.5, 0.95, 0.96, 1.0],
        }
    )  # fmt: skip
    table = trials_table(trials, passed=0.95)
    # the study asks for more than 95 %
    assert table[["trials", "completed", "passed"]].to_numpy().tolist() == [[4, 3, 1]]
    assert printable_trials(table)["Best success"].tolist() == ["96.0 %"]
