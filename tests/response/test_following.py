"""When a joint, and a data set, follows its commands closely."""

import numpy as np
import pytest

from t2l.response.following import LEAST_DAMPING, follows_closely, joint_follows_closely, most
from t2l.response.joints import responses
from t2l.response.motions import Motions
from tests.response import made

UNKNOWN = (np.nan, np.nan)
LITTLE, MUCH, EITHER = (0.02, 0.05), (0.08, 0.1), (0.05, 0.1)
DAMPED, SWINGING, OPEN = (0.8, 1.2), (0.3, 0.5), (0.5, 0.9)


def test_the_least_damping_overshoots_by_a_twentieth():
    zeta = LEAST_DAMPING
    assert np.exp(-np.pi * zeta / np.sqrt(1 - zeta**2)) == pytest.approx(0.05)


@pytest.mark.parametrize(
    ("lag", "zeta", "follows"),
    [
        (LITTLE, DAMPED, True),
        (MUCH, DAMPED, False),
        (LITTLE, SWINGING, False),
        (EITHER, DAMPED, None),
        (LITTLE, OPEN, None),
        (MUCH, UNKNOWN, False),
        (UNKNOWN, SWINGING, False),
        (LITTLE, UNKNOWN, None),
        (UNKNOWN, UNKNOWN, None),
    ],
)
def test_whole_intervals_decide(lag, zeta, follows):
    assert follows_closely(lag, zeta) is follows


def test_more_than_half_of_what_is_told_decides():
    assert most([True, True, False, None]) is True
    assert most([True, False, False]) is False
    assert most([True, False]) is None
    assert most([None]) is None


@pytest.mark.parametrize(("omega", "zeta", "follows"), [(60, 1.0, True), (8, 1.0, False)])
def test_a_stiff_joint_follows_and_a_compliant_one_does_not(omega, zeta, follows):
    time, command, q = made.rows(omega, zeta, duration_s=30.0, noise=1e-4)
    motions = Motions("made", ("joint",), ((time, command[:, None], q[:, None]),), "rad")
    assert [joint_follows_closely(one) for one in responses(motions)] == [follows]
