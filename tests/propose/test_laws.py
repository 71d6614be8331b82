"""A load by gravity is a variable of its own only where other joints change it."""

from pathlib import Path

import numpy as np
import pytest

from t2l.identify.prediction import Predictor
from t2l.propose.laws import ranges
from tests.conftest import ROOT
from tests.diagnose.made import measured, pendulum, recording, swing

ARM = ROOT / "examples/two_joint_arm/two_joint_arm.xml"


@pytest.mark.parametrize("robot", ["pendulum", "arm"])
def test_a_load_that_follows_from_the_position_is_not_followed(tmp_path: Path, robot):
    if robot == "pendulum":
        one = recording(pendulum(tmp_path), swing())
    else:

        def commands(t):
            return np.column_stack([swing(0.5, hz)(t) for hz in (0.7, 1.1)])

        one = recording(str(ARM), commands, joints=("shoulder", "elbow"))
    one = measured(one)
    predictor = Predictor(one.robot, [one], threads=1)
    q = predictor.samples.q
    laws = ranges(predictor, q, np.zeros_like(q))
    followed = {law.joint for law in laws if law.follows == "load"}
    assert followed == (set() if robot == "pendulum" else {"shoulder", "elbow"})
    assert {law.joint for law in laws if law.follows == "position"} == set(predictor.joints)
