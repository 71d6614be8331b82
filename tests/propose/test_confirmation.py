"""When validation samples confirm a curve: in place of a name it may do as well, beside it not."""

import pytest

from t2l.diagnose.evidence import gather
from t2l.effects.law import LIMIT, TORQUE, Curve, Law
from t2l.identify.model import Model
from t2l.propose.confirmation import confirmed
from tests.diagnose.made import pendulum, swings

NOISE = 1e-4


def line(slope):
    """A torque over the hinge's position, N·m/rad."""
    return Curve(Law(TORQUE, "hinge", "position", "hinge"), (-1.0, 1.0), (-slope, slope))


def limit(stall):
    """Of the motor torque, N·m."""
    return Curve(Law(LIMIT, "hinge", "velocity", "hinge"), (-40.0, 40.0), (stall + 4, stall - 4))


@pytest.mark.parametrize(
    ("slope", "in_place", "beside"),
    [(-0.1, True, True), (-0.05, True, True), (0.0, True, False), (0.05, False, False)],
    ids=["the truth", "half of it", "nothing", "the other way"],
)
def test_in_place_of_a_name_a_curve_may_do_as_well_and_beside_it_must_help(
    tmp_path, slope, in_place, beside
):
    robot = pendulum(tmp_path)
    truth = Model(robot, learned=(line(-0.1),))
    evidence = gather(robot, swings(robot, None, NOISE, model=truth)[:2], threads=1)
    for replaced, expected in ((True, in_place), (False, beside)):
        offered = Model(robot, learned=(line(slope),))
        found = confirmed(offered, Model(robot), replaced, evidence, NOISE)
        assert found == expected


@pytest.mark.parametrize(("stall", "expected"), [(1.212, True), (1.44, False)])
def test_what_acts_at_one_moment_is_confirmed_if_it_goes_half_of_the_way(tmp_path, stall, expected):
    """Half of a bootstrap's draws lack the moment at which a limit acts."""
    robot = pendulum(tmp_path)
    truth = Model(robot, learned=(limit(1.2),))
    evidence = gather(robot, swings(robot, None, NOISE, model=truth)[:2], threads=1)
    offered = Model(robot, learned=(limit(stall),))
    assert confirmed(offered, Model(robot), False, evidence, NOISE) == expected
