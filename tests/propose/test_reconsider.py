"""Names that did a part of an unknown torque give way to its curve; right ones stand."""

from dataclasses import replace

import numpy as np
import pytest

from t2l.diagnose.evidence import gather
from t2l.diagnose.forward_selection import Explanation
from t2l.effects.law import TORQUE, Law
from t2l.identify.model import Model
from t2l.identify.prediction import Predictor
from t2l.propose.bases import effect_of
from t2l.propose.beside import proposed_beside
from t2l.propose.laws import before_leaving
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


def test_what_a_recording_shows_before_it_goes_further_than_those_learned_from(tmp_path):
    robot = pendulum(tmp_path)
    predictor = Predictor(robot, machine(robot, []), threads=1)
    samples = predictor.samples
    law = Law(TORQUE, "hinge", "velocity", "hinge")
    dq = np.where(samples.time > 0.5 + samples.recording, 4.0, 1.0)

    def known(ends):
        effect = effect_of(law, ends, 0.1)
        return before_leaving([effect], predictor, samples.q, dq)

    assert known((-4.0, 4.0)).all()
    # the first recording from half a second on; the second is over before
    np.testing.assert_array_equal(
        known((-1.0, 2.0)), (samples.time <= 0.5) | (samples.recording > 0)
    )
    assert not known((2.0, 5.0)).any()


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
