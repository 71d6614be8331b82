import numpy as np
import pandas as pd

from t2l.gains import Cell, Grid
from t2l.robots import make_robot
from t2l.study.landscape.again import choice_of, no_curve, passed
from t2l.study.landscape.statistics import Searched, landscape_table, printable_landscape
from tests.study.judged import CLAIMS
from tests.study.planted import evidence

GRID = Grid(kp=(16, 512), kd=(2, 24), compliant_up_to_kp=128, overdamped_from_kd=8)
TRIALS = pd.DataFrame(
    {
        "number": [0, 1, 2, 3, 4],
        "state": ["complete", "complete", "pruned", "complete", "complete"],
        "success": [0.96, 0.5, 1.0, 0.97, 0.98],
        "action_scale_proximal": [0.1, 0.2, 0.3, 0.4, 0.5],
        "action_scale_distal": [0.01, 0.02, 0.03, 0.04, 0.05],
    }
)


def again(configuration, seed, success):
    rows = [(configuration, seed, 10 * i, 0, 0.0, s, 16, 24) for i, s in enumerate(success)]
    return pd.DataFrame(rows, columns=no_curve().columns)


def test_the_first_trials_that_pass_are_trained_again_and_not_the_best():
    good = passed(TRIALS.sample(frac=1, random_state=0), 0.95, most=2)
    assert good.number.tolist() == [0, 3]
    assert choice_of(good.iloc[1], make_robot("fr3"), ()).action_scale == (0.4, 0.04)


def test_trials_are_counted_beside_the_studys():
    runs = pd.concat([again(0, 1, [0.2, 0.97, 0.9]), again(0, 2, [0.2, 0.5]), again(3, 1, [0.96])])
    searched = [
        Searched("joint_reach", Cell(16, 24), TRIALS, runs),
        Searched("joint_reach", Cell(512, 8), TRIALS.iloc[:0], no_curve()),
    ]
    table = landscape_table(searched, GRID, passed=0.95, exists=0.99)
    first, none = table.iloc[0], table.iloc[1]
    assert (first.trials, first.passed, first.published_passed) == (4, 3, 32)
    # a pruned trial is no proof
    assert first.best_success == 0.98
    assert not first.exists
    assert (first.configurations, first.runs, first.passed_again) == (2, 3, 2)
    # one of both passed with each of its seeds
    assert (first.always_again, none.always_again) == (1, 0)
    assert (none.trials, none.passed, none.runs) == (0, 0, 0)
    assert np.isnan(none.published_passed)
    text = printable_landscape(table)
    assert text["Trials that pass"].tolist() == ["3 of 4", "0 of 0"]
    assert text["With every seed"].tolist() == ["1 of 2", "0 of 0"]
    assert text["The study"].tolist() == ["32 of 50", "–"]


def test_a_trial_passes_above_the_study_s_rate_wherever_it_is_asked():
    """Counted, judged and trained again by one rule: the study's "above 95 %"."""
    rates = (0.95, 0.96)
    trials = pd.concat(
        [TRIALS.iloc[:1].assign(success=rate, number=i) for i, rate in enumerate(rates)]
    )
    assert passed(trials, 0.95, most=5).success.tolist() == [0.96]
    [row] = landscape_table(
        [Searched("joint_reach", Cell(16, 24), trials, again(0, 1, [0.95]))], GRID, 0.95, 0.99
    ).itertuples()
    assert (row.passed, row.passed_again) == (1, 0)
    corners = [trials.assign(kp=kp, kd=kd) for kp in (16, 512) for kd in (2, 24)]
    table = {"sim_to_real__joint_reach__kp16_kd2__trials": pd.concat(corners)}
    assert CLAIMS["landscape"].finding(evidence(**table)).ours == ", ".join(["1 of 2"] * 4)
