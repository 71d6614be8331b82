"""Names that did a part of an unknown torque give way to its curve; right ones stand."""

import json
from dataclasses import replace

import numpy as np
import pytest

from t2l.diagnose.evidence import gather
from t2l.diagnose.explanation import Explanation
from t2l.effects.law import TORQUE, Law
from t2l.identify.model import Model, read_model
from t2l.identify.refit import refitted
from t2l.propose.beside import proposed_beside
from t2l.propose.proposal import error_of
from t2l.propose.reconsider import reconsider
from tests.diagnose.made import measured, pendulum, recording, swing
from tests.propose.test_search import POSITIONS, machine, planted

COULOMB = {"coulomb_friction": {"torque": {"hinge": 0.05}}}
QUADRATIC = {"quadratic_friction": {"coefficient": {"hinge": 0.02}}}
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


def test_a_law_that_fails_beyond_what_it_was_learned_from_takes_no_names_place(tmp_path):
    """Quadratic friction with a ripple, which a curve draws as well; then a faster motion."""
    robot, speeds = pendulum(tmp_path), np.linspace(-40.0, 40.0, 801)
    ripple = planted(Law(TORQUE, "hinge", "velocity", "hinge"), speeds, 0.01 * np.sin(2 * speeds))
    truth = Model(robot, QUADRATIC, learned=(ripple,))
    made = machine(robot, [], 3, noise_rad=0.0)
    fast = recording(robot, swing(0.9, 2.0), "fast", 30.0, 1.0, 1.5, control_rate_hz=500.0)
    *slow, test, fast = (measured(r, None, 1e-4, n, truth) for n, r in enumerate([*made, fast]))
    evidence = gather(robot, slow, [replace(test, name="held")], threads=1)
    validation = evidence.train.of([fast])
    evidence = replace(
        evidence, validation=validation, validation_mask=np.ones(len(validation.samples), bool)
    )
    names = Model(robot, QUADRATIC)
    found = reconsider(Model(robot), names, evidence, quiet=1.1e-4)
    assert found.dropped == ()
    assert error_of(found.model, validation) <= error_of(names, validation)


def test_a_name_that_explains_a_part_of_what_no_law_explains_is_not_adopted(tmp_path):
    """Late commands, of which an inertia does a part."""
    robot = pendulum(tmp_path)
    truth = Model(robot, {"command_delay": {"delay": 0.04}})
    made = machine(robot, [], 3, noise_rad=0.0)
    recordings = [measured(r, None, 1e-4, seed, truth) for seed, r in enumerate(made)]
    evidence = gather(robot, recordings[:2], [replace(recordings[2], name="held")], threads=1)
    names = {"armature": {"inertia": {"hinge": 0.001}}}
    names = refitted(Model(robot, names), evidence.train, evidence.train_mask)
    given = Explanation([], "unexplained", 1e-4, "", names)
    found = proposed_beside(Model(robot), given, evidence, tmp_path / "out")
    assert found.model.effects == {}
    assert found.verdict == "unexplained"
    assert found.sentence.startswith("Unexplained. Armature explains only a part")
    assert found.partial.effects == ("armature",)
    assert 0 < found.partial.explained < 1
    kept = read_model(tmp_path / "out/proposal/partial.yaml")
    assert list(kept.effects) == ["armature"]
    content = json.loads((tmp_path / "out/proposal/proposal.json").read_text())
    assert content["known"] == [{"effect": "armature", "stands": False, "partial": True}]

    told = []
    again = proposed_beside(
        Model(robot), given, evidence, tmp_path / "out", lambda *what: told.append(what)
    )
    assert not told
    assert again == found


@pytest.mark.parametrize("stands", [False, True])
def test_a_name_gives_way_to_a_law_that_does_as_much_with_fewer_numbers(tmp_path, stands):
    """A soft spring far from its rest does what a constant torque does; a stiff one does not."""
    robot = pendulum(tmp_path)
    spring = {"parallel_spring": {"stiffness": {"hinge": 0.1}, "rest": {"hinge": 0.5}}}
    truth = Model(robot, spring if stands else {"torque_offset": {"torque": {"hinge": 0.04}}})
    made = machine(robot, [], 3, noise_rad=0.0)
    recordings = [measured(r, None, 1e-4, seed, truth) for seed, r in enumerate(made)]
    evidence = gather(robot, recordings[:2], [replace(recordings[2], name="held")], threads=1)
    soft = {"parallel_spring": {"stiffness": {"hinge": 0.002}, "rest": {"hinge": 20.0}}}
    names = Model(robot, spring if stands else soft)
    found = reconsider(Model(robot), names, evidence, quiet=2e-4)
    if stands:
        assert found is None
    else:
        assert found.dropped == ("parallel_spring",)
        assert [one.curve.law.follows for one in found.proposal.learned] == ["constant"]


def test_two_names_give_way_to_one_formula_of_fewer_constants(tmp_path):
    """A ripple, and a spring that is not there: a curve has as many numbers, a sine has fewer."""
    pytest.importorskip("pyoperon")
    robot = pendulum(tmp_path)
    law = Law(TORQUE, "hinge", "position", "hinge")
    ripple = planted(law, POSITIONS, 0.05 * np.sin(4 * POSITIONS + 0.4))
    recordings = machine(robot, [ripple], 3)
    evidence = gather(robot, recordings[:2], [replace(recordings[2], name="held")], threads=1)
    near = {"amplitude": 0.045, "phase": 0.5, "periods": 4.0}
    spring = {"parallel_spring": {"stiffness": {"hinge": 0.02}, "rest": {"hinge": 8.0}}}
    cogging = {"cogging": {name: {"hinge": value} for name, value in near.items()}}
    names = refitted(Model(robot, spring | cogging), evidence.train, evidence.train_mask)
    assert error_of(names, evidence.train, evidence.train_mask) < 1.1e-4
    found = reconsider(Model(robot), names, evidence, quiet=2e-4)
    assert set(found.dropped) == {"parallel_spring", "cogging"}
    assert [one.curve.law for one in found.proposal.learned] == [law]


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
