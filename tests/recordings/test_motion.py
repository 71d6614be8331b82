import numpy as np
import pytest

from t2l.errors import RecordingError
from t2l.recordings.motion import check_motion
from tests.recordings.made import recording


def still(place):
    made = recording()
    return recording(q=np.full_like(made.q, place), q_des=np.full_like(made.q_des, place))


def test_rows_that_are_all_alike_tell_nothing():
    with pytest.raises(RecordingError, match=r"swing: columns q_des.\* and q.\*: found the same"):
        check_motion([still(0.3)])
    with pytest.raises(RecordingError, match="of all recordings: found the same number"):
        check_motion([still(0.3), still(0.3)])


def test_a_joint_that_moves_or_is_held_elsewhere_does():
    check_motion([recording()])
    check_motion([still(0.3), still(0.4)])
