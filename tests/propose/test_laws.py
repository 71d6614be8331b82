"""Over a load by gravity a law bends only where other joints change the load."""

from pathlib import Path

import numpy as np
import pytest

from t2l.effects.law import TORQUE, Law
from t2l.identify.prediction import Predictor
from t2l.propose.laws import lines
from tests.conftest import ROOT
from tests.diagnose.made import measured, pendulum, recording, swing

ARM = ROOT / "examples/two_joint_arm/two_joint_arm.xml"


@pytest.mark.parametrize("robot", ["pendulum", "arm"])
def test_over_a_load_that_follows_from_the_position_a_law_is_a_line(tmp_path: Path, robot):
    if robot == "pendulum":
        one = recording(pendulum(tmp_path), swing())
    else:

        def commands(t):
            return np.column_stack([swing(0.5, hz)(t) for hz in (0.7, 1.1)])

        one = recording(str(ARM), commands, joints=("shoulder", "elbow"))
    one = measured(one)
    found = lines(Predictor(one.robot, [one], threads=1))
    assert found == ({Law(TORQUE, "hinge", "load", "hinge")} if robot == "pendulum" else set())
