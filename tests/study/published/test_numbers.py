import pytest

from t2l.study.published.numbers import claims, splits


def test_every_number_says_where_it_stands():
    for key, entry in claims().items():
        assert entry.section, key
        assert entry.theirs, key


@pytest.mark.parametrize(
    ("key", "cells", "regions"),
    [
        # Kp up to 128, Kd from 16 on
        ("cloning", [(128, 16), (256, 16), (128, 8), (256, 8)], ["CO", "SO", "CU", "SU"]),
        # Kp from 128 on, Kd from 8 on
        ("transfer", [(64, 8), (128, 8), (64, 4), (128, 4)], ["CO", "SO", "CU", "SU"]),
    ],
)
def test_a_grid_is_split_where_the_study_does(key, cells, regions):
    kp, kd = zip(*cells, strict=True)
    assert splits()[key].regions(kp, kd).tolist() == regions


def test_what_does_not_add_up_is_said():
    for key in ("co_handover", "co_unloading", "co_loading"):
        assert "does not follow" in claims()[key].note
    assert "1297" in claims()["teleoperation_success"].note
    assert "lacks the time" in claims()["variance_theorem"].note
    assert "mean over joints" in claims()["transfer_joint_reach"].note
