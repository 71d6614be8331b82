import pytest

from t2l.study.published.cells import errors


def test_the_studys_own_errors_are_known_by_cell():
    published = errors().set_index(["kp", "kd"]).published
    assert len(published) == 49
    # the two greatest of the page: (512, 16) and (16, 24)
    assert published.nlargest(2).index.tolist() == [(512, 16), (16, 24)]
    assert published[512, 24] == pytest.approx(0.0138, rel=0.01)
