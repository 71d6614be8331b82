"""Which first guess each joint takes, and what all joints share."""

import numpy as np
import pytest

from t2l.diagnose.starting_points import choose
from t2l.effects.registry import builtin

BACKLASH = builtin()["backlash"]
JOINT = np.array([0, 0, 1, 1])  # of each sample
BEFORE = np.full(4, 1e-3)  # rad, the residual without the effect
# guesses: play of 0.01 and 0.03 rad with the encoder on the motor, then on the link
STARTS = [
    {
        "play": np.full(2, play),
        "contact_time": np.full(2, 3e-3),
        "contact_damping": np.full(2, 0.2),
        "encoder_on_link": np.array([link]),
    }
    for link in (0.0, 1.0)
    for play in (0.01, 0.03)
]


def chosen(left: list[float], right: list[float]) -> dict:
    """The choice where each guess leaves so many rad on the left and the right joint."""
    after = np.repeat(np.array([left, right]).T, 2, axis=1)
    return choose(BACKLASH, STARTS, BEFORE, after, JOINT, 2)


def test_each_joint_takes_the_guess_that_helps_it():
    found = chosen([5e-4, 9e-4, 2e-3, 2e-3], [9e-4, 5e-4, 2e-3, 2e-3])
    assert found["play"] == pytest.approx([0.01, 0.03])
    assert found["encoder_on_link"] == [0.0]


def test_a_joint_that_nothing_helps_has_no_say_in_what_all_share():
    found = chosen([9e-4, 9e-4, 1e-4, 9e-4], [2e-3, 2e-3, 0.5, 0.5])
    assert found["encoder_on_link"] == [1.0]


@pytest.mark.parametrize("link", [0, 1])
def test_where_nothing_helps_the_least_harm_decides_what_all_share(link):
    mild, harsh = [2e-3, 3e-3], [2e-2, 3e-2]
    left = [*harsh, *mild] if link else [*mild, *harsh]
    assert chosen(left, left)["encoder_on_link"] == [float(link)]
