"""Models with learned torques, and proposals, that `t2l adopt` and `t2l export` are given."""

import json
import shutil
from pathlib import Path

import pytest
import yaml
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from t2l.cli.main import main
from t2l.identify.model import ModelFile
from tests.diagnose.made import pendulum
from tests.fuzz.generate import FOREIGN, as_bytes, spoilt
from tests.fuzz.harness import check

QUIET = {"deadline": None, "suppress_health_check": list(HealthCheck)}
NAME = "formula_torque_hinge_position"
MODEL = {
    "robot": "pendulum.xml",
    "effects": {NAME: {"a": {"hinge": 0.1}, "b": {"hinge": 2.0}}},
    "learned": [
        {"kind": "friction", "joint": "hinge", "follows": "speed", "at": [0, 1], "torque": [0, 0.1]}
    ],
    "formulas": [
        {
            "kind": "torque", "joint": "hinge", "follows": "position", "of": "hinge",
            "formula": "a * sin(b * x)",
            "constants": {
                "a": {"unit": "N·m", "lower": -1, "upper": 1}, "b": {"lower": -9, "upper": 9},
            },
        }
    ],
}  # fmt: skip
PROPOSAL = {
    "verdict": "law",
    "sentence": "A torque on hinge.",
    "curves": [{"name": "learned_torque_hinge_position", "formula": {"effect": NAME}}],
}
GAINS = ["--kp", "20", "--kd", "0.8", "--control-rate-hz", "500", "--gravity-compensation", "no"]
TEXTS = st.one_of(
    FOREIGN.filter(lambda value: isinstance(value, str)),
    st.sampled_from(
        ["__import__('os').system('touch evil')", "a*x**x**x**9", "a / 0 * b * x", "log(-b) * a*x",
         "a * b", "exp(exp(exp(a + b * x)))", "a.real * b * x", "x" * 600, "a b", "-" * 400 + "x"]
    ),
    st.text("ab x*/+-().,sincoexplg019e_'\"\n", max_size=30),
)  # fmt: skip


@pytest.fixture(scope="module")
def home(tmp_path_factory) -> Path:
    home = tmp_path_factory.mktemp("home")
    pendulum(home)
    return home


@st.composite
def models(draw):
    """A model with a formula, and what is wrong with most."""
    document = draw(spoilt(MODEL, ModelFile))
    if draw(st.booleans()):
        document["formulas"] = [MODEL["formulas"][0] | {"formula": draw(TEXTS)}]
    return draw(as_bytes(document))


@settings(max_examples=60, **QUIET)
@given(data=st.data())
def test_exports(home, data):
    (home / "bad_model.yaml").write_bytes(data.draw(models()))
    check(
        lambda: main(["export", "bad_model.yaml", *GAINS, "--out", "out"]), home, home / "out",
        ("bad_model", "pendulum.xml", "--"),
    )  # fmt: skip
    assert not [*home.rglob("evil")]
    for path in (home / "out").glob("*.py"):
        assert "touch" not in path.read_text()
    shutil.rmtree(home / "out", ignore_errors=True)


@settings(max_examples=60, **QUIET)
@given(data=st.data())
def test_adoptions(home, data):
    folder = home / "found"
    (folder / "models").mkdir(parents=True, exist_ok=True)
    document = data.draw(spoilt(PROPOSAL, ModelFile))
    (folder / "proposal.json").write_bytes(data.draw(as_bytes(document, json_too=True)))
    robot = MODEL | {"robot": "../../pendulum.xml"}
    content = yaml.safe_dump(robot).encode() if data.draw(st.booleans()) else data.draw(models())
    (folder / f"models/{NAME}.yaml").write_bytes(content)
    name = data.draw(st.sampled_from([NAME, NAME, "learned_torque_hinge_position", "../../evil"]))
    check(
        lambda: main(["adopt", name, "--diagnosis", "found", "--out", "out/model.yaml"]), home,
        home / "out", ("found", name),
    )  # fmt: skip
    assert not [*home.rglob("evil")]
    shutil.rmtree(home / "out", ignore_errors=True)


def test_the_sound_ones_are_taken(home):
    """Else the others show nothing."""
    (home / "found/models").mkdir(parents=True, exist_ok=True)
    (home / "found/proposal.json").write_text(json.dumps(PROPOSAL))
    content = yaml.safe_dump(MODEL | {"robot": "../../pendulum.xml"})
    (home / f"found/models/{NAME}.yaml").write_text(content)
    (home / "sound.yaml").write_text(yaml.safe_dump(MODEL))
    adopt = ["adopt", NAME, "--diagnosis", "found", "--out", "out/model.yaml"]
    assert check(lambda: main(adopt), home, home / "out") is None
    shutil.rmtree(home / "out")
    export = ["export", "sound.yaml", *GAINS, "--out", "out"]
    assert check(lambda: main(export), home, home / "out") is None
    shutil.rmtree(home / "out")
