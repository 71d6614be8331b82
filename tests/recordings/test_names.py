import dataclasses

from t2l.recordings.names import unique_names
from tests.diagnose.made import recording, swing


def test_names_are_unique(tmp_path):
    one = recording("arm.xml", swing(), "kp5", duration_s=0.5)
    folders = [
        dataclasses.replace(one, path=tmp_path / name / "kp5.csv") for name in ("train", "holdout")
    ]
    assert unique_names(folders) == ("train/kp5", "holdout/kp5")
    assert unique_names([one] * 2) == ("kp5", "kp5 (2)")
