import numpy as np
import pandas as pd
import pytest

from t2l.study.decoupling.pairing import Pairing
from t2l.study.decoupling.statistics import decoupling_table, printable_decoupling
from t2l.study.decoupling.summary import chosen, summarise

STIFF = Pairing("stiff", 16.0, 8.0, {}, 0.01, 0.0)
SOFT = Pairing("soft", 512.0, 24.0, {}, 1.0, 0.1)


def run(*stiffness, passive):
    """Two evaluations: the last counts, and of it the median over directions."""
    last = [(20, i, k, passive, 0.0, 0.5, 1.0, 1.0) for i, k in enumerate(stiffness)]
    columns = ["update", "direction", "stiffness_n_m", "passive_n_m", "drift", "swing",
               "success", "reward"]  # fmt: skip
    return pd.DataFrame([(10, 0, 1e9, passive, 0.0, 0.0, 0.0, 0.0), *last], columns=columns)


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
    assert printable_decoupling(few).p.tolist() == ["not told", "–"]


def test_a_tool_that_drifts_or_a_pose_that_is_not_held_has_no_stiffness_to_compare():
    told = [900, 1000, 1200], [180, 200, 250]
    for lacking in ({"drift": 1.6}, {"success": 0.4}):
        table = decoupling_table(trainings(*told, **lacking), ["stiff", "soft"])
        assert table.ratio[0] == 5
        assert np.isnan(table.p[0])
    drifts = printable_decoupling(decoupling_table(trainings(*told, drift=1.6), ["stiff", "soft"]))
    assert drifts["Drift when pushed"].tolist() == ["0 %", "160 %"]
    assert drifts["Holds the pose"].tolist() == ["100 %", "100 %"]


def swept(holds):
    """Seven seeds of three weights of the soft arm, and one of the stiff one."""
    rows = [
        (f"soft_{weight}", 16, seed, 100.0 * weight + seed, 0.01, float(holds(weight, seed)))
        for weight in (1, 2, 3)
        for seed in range(1, 8)
    ]
    rows += [("stiff", 512, seed, 50.0, 0.01, 1.0) for seed in range(1, 8)]
    columns = ["pairing", "kp", "seed", "stiffness_n_m", "drift", "success"]
    return pd.DataFrame(rows, columns=columns)


def test_the_first_seeds_choose_a_weight_and_the_others_tell():
    # the third weight holds in the seeds that tell, and in none that chooses
    found = chosen(swept(lambda weight, seed: weight == 2 or (weight == 3 and seed > 2)))
    assert sorted(found.pairing.unique()) == ["soft_2", "stiff"]
    assert sorted(found.seed.unique()) == [3, 4, 5, 6, 7]
    assert found.groupby("pairing").size().tolist() == [5, 5]


def test_nothing_is_chosen_where_there_is_one_weight():
    one = swept(lambda weight, seed: True).query("pairing in ('soft_1', 'stiff')")
    assert len(chosen(one)) == 14


def test_a_pose_is_held_within_the_tolerance_of_its_reward():
    file = {"kind": "pose_hold", "robot": "fr3", "tolerance_rad": 0.1, "largest_force_n": 30.0,
            "shortest_push_s": 0.2, "longest_push_s": 1.0, "push_every_s": 2.0}  # fmt: skip
    wide = Pairing("wide", 512.0, 24.0, {"kind": "joint_delta"}, 1.0, 0.1, 1.0)
    own = Pairing("own", 512.0, 24.0, {"kind": "joint_delta"}, 1.0, 0.1)
    tolerances = [one.problem("pose_hold", file, 2.0).task.tolerance_rad for one in (wide, own)]
    assert tolerances == [1.0, 0.1]
