"""Names that did a part of an unknown torque give way to its curve; right ones stand."""

from dataclasses import replace

import numpy as np
import pytest

from t2l.diagnose.evidence import gather
from t2l.diagnose.forward_selection import Explanation
from t2l.effects.law import TORQUE, Law
from t2l.identify.model import Model
from t2l.propose.beside import proposed_beside
from tests.diagnose.made import measured, pendulum
from tests.propose.test_search import POSITIONS, machine, planted

COULOMB = {"coulomb_friction": {"torque": {"hinge": 0.05}}}
COGGING = {
    "cogging": {
        "amplitude": {"hinge": 0.05}, "phase": {"hinge": 2.5}, "periods": {"hinge": 3.0},
    }
}  # fmt: skip


def hidden(robot, effects):
    """A spring, and known effects, in recordings to fit and one to judge by."""
    curve = planted(Law(TORQUE, "hinge", "position", "hinge"), POSITIONS, -0.1 * POSITIONS)
    made = machine(robot, [], 3, noise_rad=0.0)
    truth = Model(robot, effects, learned=(curve,))
    recordings = [measured(r, None, 1e-4, seed, truth) for seed, r in enumerate(made)]
    return gather(robot, recordings[:2], [replace(recordings[2], name="held")], threads=1)


@pytest.mark.slow
def test_a_wrong_name_gives_way_and_a_right_one_stands(tmp_path):
    robot = pendulum(tmp_path)
    evidence = hidden(robot, COULOMB)
    given = Explanation([], "unexplained", 1e-4, "", Model(robot, COULOMB | COGGING))
    found = proposed_beside(Model(robot), given, evidence, tmp_path / "out")
    assert list(found.model.effects) == ["coulomb_friction"]
    assert "a torque on hinge that falls with its position" in found.sentence
    assert found.verdict == "unexplained"

    told = []
    again = proposed_beside(
        Model(robot), given, evidence, tmp_path / "out", lambda *what: told.append(what)
    )
    assert not told
    assert again.sentence == found.sentence
    coulomb = again.model.effects["coulomb_friction"]["torque"]["hinge"]
    assert coulomb == pytest.approx(0.05, rel=0.1)
    assert np.isclose(coulomb, found.model.effects["coulomb_friction"]["torque"]["hinge"], 1e-4)
