"""Whether what is known before training tells more than its rivals, on planted correlations."""

import pandas as pd
import pytest

from t2l.study.attenuation.ranking import RIVALS, SIGNS, over_tasks

TASKS = 6


def table(predicted, rival):
    """ρ of the predicted error and of all else in each task, as strengths."""
    return pd.DataFrame(
        [
            {"task": str(task), "predictor": name, "expected": sign,
             "rho": sign * (predicted(task) if name == "predicted_error" else rival)}
            for task in range(TASKS)
            for name, sign in SIGNS.items()
        ]
    )  # fmt: skip


@pytest.mark.parametrize(
    ("predicted", "p"),
    [
        (lambda task: 0.8 + 0.01 * task, 2 / 2**TASKS),
        (lambda task: 0.4 - 0.01 * task, 1.0),
        # better in half of the tasks
        (lambda task: 0.5 + (0.1 if task % 2 else -0.1), 1.0),
    ],
)
def test_it_must_tell_more_in_tasks_beyond_chance(predicted, p):
    found = over_tasks(table(predicted, rival=0.5)).set_index("predictor").loc[list(RIVALS)]
    assert found.p.tolist() == pytest.approx([p, p])
    assert (found.n == TASKS).all()


def test_signs_are_those_of_theory():
    # a number with the wrong sign counts against it, however strong
    found = over_tasks(table(lambda task: -0.9, rival=0.5)).set_index("predictor")
    assert found.rho["predicted_error"] == pytest.approx(-0.9)
    assert (found.more[list(RIVALS)] < -1).all()
