import dataclasses
import textwrap

import numpy as np
import pytest

from t2l.detective.data_split import split
from t2l.detective.ranking import diagnose
from t2l.diagnose.ranking import MISSING, NOTHING_MISSING, adopt
from t2l.effects.registry import builtin, load
from t2l.errors import ConfigurationError
from t2l.identify.model import Model, read_model, write_model
from tests.diagnose.made import all_but, predict, spinner, swings

RUBBER = '''
"""A rubber cord that pulls a joint back to zero."""

from t2l.effects import Effect, Parameter


class Rubber(Effect):
    """τ = −k q."""

    name = "rubber"
    title = "rubber cord"
    parameters = (Parameter("stiffness", "N·m/rad", 0.0, 100.0, "of the cord"),)
    summary = "a cord that pulls the joint back to zero"
    signature = "the error follows the position"
    source = "Hooke"

    def install(self, loop, rows, joints, values):
        def add(tick, q, dq, torque):
            torque[rows, joints] -= values["stiffness"] * q[rows, joints]

        loop.joint_torques.append(add)

    def starts(self, scales):
        return [{"stiffness": factor * scales.kp} for factor in (0.01, 0.1)]
'''


@pytest.fixture
def rubber(tmp_path):
    path = tmp_path / "my_effects" / "rubber.py"
    path.parent.mkdir()
    path.write_text(RUBBER)
    return path


def test_a_users_effect_is_diagnosed_adopted_and_kept(tmp_path, rubber):
    robot, k = spinner(tmp_path), 1.7
    machine = Model(robot, {"rubber": {"stiffness": {"hinge": k}}}, (rubber,))
    recordings = swings(robot, model=machine, control_rate_hz=250.0)

    without = all_but("viscous_friction", "torque_offset")
    data = split(robot, recordings, threads=1)
    diagnosis = diagnose(Model(robot, {}, (rubber,), without=without), data)
    assert diagnosis.verdict == MISSING
    assert diagnosis.ranking[0].effect.name == "rubber"

    adopted = adopt(diagnosis, "rubber")
    assert adopted.effects["rubber"]["stiffness"]["hinge"] == pytest.approx(k, rel=0.01)
    write_model(adopted, tmp_path / "models" / "found.yaml", "by a test")
    again = read_model(tmp_path / "models" / "found.yaml", trusted=(rubber,))
    assert again.robot == adopted.robot
    assert again.effect_files == (rubber,)
    np.testing.assert_allclose(
        predict(recordings, model=again), predict(recordings, model=adopted), atol=1e-6
    )
    again = dataclasses.replace(again, without=without)
    assert diagnose(again, data).verdict == NOTHING_MISSING


def test_a_folder_holds_effects(rubber):
    found = load([rubber.parent])
    assert set(found) == {*builtin(), "rubber"}
    assert "rubber" not in builtin()


def broken(old, new):
    return RUBBER.replace(old, new)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("import no_such_package", "cannot be imported.*no_such_package"),
        ("def oops(:", "cannot be imported"),
        ("x = 1", "defines no subclass"),
        ("from t2l.effects.armature import Armature", "defines no subclass"),
        (broken('    source = "Hooke"\n', ""), "lacks `source`"),
        (broken('    name = "rubber"\n', ""), "lacks `name`"),
    ],
)
def test_a_file_that_defines_no_effect_is_named(tmp_path, text, message):
    path = tmp_path / "mine.py"
    path.write_text(textwrap.dedent(text))
    with pytest.raises(ConfigurationError, match=message) as caught:
        load([path])
    assert str(path) in str(caught.value)


def test_an_effect_without_first_guesses_is_named(tmp_path):
    path = tmp_path / "mine.py"
    path.write_text(RUBBER.split("    def starts")[0])
    with pytest.raises(ConfigurationError, match=r"mine\.py.*starts"):
        load([path])


def test_a_missing_file_is_named(tmp_path):
    with pytest.raises(ConfigurationError, match=r"nowhere\.py: no such file"):
        load([tmp_path / "nowhere.py"])


def test_a_file_with_postponed_annotations_and_a_dataclass_is_read(tmp_path):
    """Both are everyday Python; together they need the module to be importable by name."""
    path = tmp_path / "mine.py"
    extra = "from dataclasses import dataclass\n\n\n@dataclass\nclass Cord:\n    k: float = 1.0\n"
    body = RUBBER.split('"""\n\n', 1)[1]
    path.write_text(f"from __future__ import annotations\n\n{extra}\n\n{body}")
    assert "rubber" in load([path])
