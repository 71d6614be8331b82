import numpy as np
import pandas as pd
import pytest

from t2l.decoupling.pairing import Pairing
from t2l.decoupling.summary import summarise
from t2l.stats.decoupling import decoupling_table, printable

STIFF = Pairing("stiff", 16.0, 8.0, {}, 0.01, 0.0)
SOFT = Pairing("soft", 512.0, 24.0, {}, 1.0, 0.1)


def run(*stiffness, passive):
    """Two evaluations: the last counts, and of it the median over directions."""
    last = [(20, i, k, passive, 0.0, 1.0, 1.0) for i, k in enumerate(stiffness)]
    columns = ["update", "direction", "stiffness_n_m", "passive_n_m", "drift", "success", "reward"]
    return pd.DataFrame([(10, 0, 1e9, passive, 0.0, 0.0, 0.0), *last], columns=columns)


def trainings(stiff, soft, **last):
    """With `drift` or `success` of the stiff arm's last evaluations."""
    tables = {}
    for seed, (a, b) in enumerate(zip(stiff, soft, strict=True), start=1):
        tables[STIFF, seed] = run(a / 2, a, 5 * a, passive=30.0)
        tables[SOFT, seed] = run(b / 2, b, 5 * b, passive=900.0).assign(**last)
    return summarise(tables)


def test_a_planted_ratio_is_found_over_seeds():
    table = decoupling_table(trainings([900, 1000, 1200], [180, 200, 250]), ["stiff", "soft"])
    stiff, soft = table.iloc[0], table.iloc[1]
    assert (stiff.stiffness_n_m, soft.stiffness_n_m) == (1000, 200)
    assert stiff.ratio == 5
    assert stiff.ratio_least == 900 / 250
    assert stiff.ratio_most == 1200 / 180
    assert stiff.gain_ratio == 16 / 512
    assert stiff.passive_ratio == pytest.approx(1 / 30)
    # the least attainable with three seeds of each
    assert stiff.p == pytest.approx(1 / 20)
    assert np.isnan(soft.p)


def test_its_absence_is_found_too_and_two_seeds_have_no_p():
    table = decoupling_table(trainings([20, 30, 40], [800, 900, 1000]), ["stiff", "soft"])
    assert table.ratio[0] < 0.1
    assert table.p[0] == pytest.approx(1.0)
    few = decoupling_table(trainings([900, 1000], [180, 200]), ["stiff", "soft"])
    assert np.isnan(few.p[0])
    assert printable(few).p.tolist() == ["not told", "–"]


def test_a_tool_that_drifts_or_a_pose_that_is_not_held_has_no_stiffness_to_compare():
    told = [900, 1000, 1200], [180, 200, 250]
    for lacking in ({"drift": 1.6}, {"success": 0.0}):
        table = decoupling_table(trainings(*told, **lacking), ["stiff", "soft"])
        assert table.ratio[0] == 5
        assert np.isnan(table.p[0])
    drifts = printable(decoupling_table(trainings(*told, drift=1.6), ["stiff", "soft"]))
    assert drifts["Drift when measured"].tolist() == ["0 %", "160 %"]
    assert drifts["Holds the pose"].tolist() == ["100 %", "100 %"]
