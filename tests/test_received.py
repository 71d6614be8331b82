"""What is received is data: no name, note, path or formula of somebody's becomes a program."""

import ast
import dataclasses
import json
import os
import shutil
from pathlib import Path

import mujoco
import numpy as np
import pytest
import yaml

from t2l import documents, registry
from t2l.cli.main import main
from t2l.cli.terminal import printable
from t2l.documents import read_json, read_yaml
from t2l.effects.expression import evaluate, parse
from t2l.effects.law import TENDON, TORQUE, Curve, Law
from t2l.errors import ConfigurationError, OutputError, RecordingError
from t2l.identify.model import Model, read_model, write_model
from t2l.identify.prediction import Predictor
from t2l.outputs import MARK, claim, output_folder
from t2l.propose import formula as formulas
from t2l.propose.artefacts import formula_law, with_formula, write_proposal
from t2l.propose.expression import Formula
from t2l.propose.proposal import LAW, Learned, Proposal
from t2l.recordings import write_recording
from t2l.recordings.log import read_recordings
from t2l.robots import plant
from tests.diagnose.made import pendulum, swings
from tests.effects.test_registry import RUBBER

# ends literals, comments and attributes of Python, shells, YAML, HTML and of str.format
HOSTILE = (
    """e\"\"\";__import__("os").system("touch X");\"\"\"';open('X','w');'{0}{x} #: [`touch X`] """
    "</script><script>"
)
NAME = HOSTILE.replace("/", "_")  # that a file may have
AT = np.linspace(-1.0, 1.5, 30)


def in_xml(text):
    return text.replace("&", "&amp;").replace('"', "&quot;").replace("<", "&lt;")


@pytest.fixture
def home(tmp_path, monkeypatch):
    """A robot and recordings with such text wherever a text may stand."""
    monkeypatch.chdir(tmp_path)
    text = Path(pendulum(tmp_path)).read_text()
    text = text.replace('"hinge"', f'"{in_xml(HOSTILE)}"').replace(
        "<mujoco>", f'<mujoco model="{in_xml(HOSTILE)}">'
    )
    text = text.replace("<body ", f'<body name="{in_xml(HOSTILE)}" ')
    (tmp_path / "pendulum.xml").unlink()
    robot = tmp_path / f"{NAME}.xml"
    robot.write_text(text)
    return tmp_path


def machine(home):
    """Recordings of a spring that the model lacks, and its curve."""
    robot = str(home / f"{NAME}.xml")
    law = Law(TORQUE, HOSTILE, "position", HOSTILE)
    curve = Curve(law, tuple(AT.tolist()), tuple((-0.1 * AT).tolist()))
    logs = swings(
        robot, model=Model(robot, learned=(curve,)), duration_s=0.6, joints=(HOSTILE,),
        notes=HOSTILE,
    )  # fmt: skip
    for number, log in enumerate(logs):
        write_recording(log, home / "logs" / f"{number} {NAME}")
    return robot, curve, logs


def checked(folder):
    """Nothing ran, what is program is the library's, and what is data can be read back."""
    assert not [*folder.rglob("X")]
    for path in folder.rglob("*.py"):
        text = path.read_text()
        ast.parse(text)
        assert "touch X" not in text
    for path in folder.rglob("*.json"):
        read_json(path, "what was written")
    for path in folder.rglob("*.yaml"):
        read_yaml(path, "what was written")
    for path in folder.rglob("*.xml"):
        mujoco.MjSpec.from_file(str(path))


@pytest.mark.skipif(not formulas.installed(), reason="pyoperon is not installed")
def test_names_of_a_robot_and_its_recordings_stay_data_to_the_end(home, capsys):
    robot, curve, logs = machine(home)
    predictor = Predictor(robot, logs, threads=1)
    learned = Learned(curve, np.array(curve.torque) - 3e-3, np.array(curve.torque) + 3e-3)
    proposal = Proposal(
        LAW, Model(robot), (HOSTILE,), (learned,), 1e-4, 2e-3, 1e-4, None, None, (), ("a", "b"), ()
    )
    every = np.ones(len(predictor.samples), bool)
    content = write_proposal(proposal, home / "found", [(predictor, every)], predictor)
    name = content["curves"][0]["formula"]["effect"]
    assert name.startswith("formula_torque_e")
    main(["adopt", name, "--diagnosis", "found", "--out", "model.yaml"])
    model = read_model("model.yaml")
    assert model.effects[name]["a"][HOSTILE] == pytest.approx(-0.1, rel=0.05)
    main(["compare", "logs", "--model", "model.yaml", "--out", "compared"])
    left = json.loads((home / "compared/comparison.json").read_text())["rmse_q_rad"]
    assert left < 3e-4
    main(["export", "model.yaml", "--logs", "logs", "--out", "exported"])
    assert json.loads((home / "exported/export.json").read_text())["from_t2l_rad"] < 1e-4
    assert json.loads((home / "exported/robot.json").read_text())["joints"] == [HOSTILE]
    checked(home)


def test_a_torque_on_two_joints_is_written_as_data(tmp_path):
    law = Law(TENDON, HOSTILE, "position", f"other {HOSTILE}")
    formula = formula_law(law, Formula("a * x", {"a": -0.5}, {"a": HOSTILE}), 0.3)
    model = with_formula(Model(pendulum(tmp_path)), formula, {"a": -0.5})
    write_model(model, tmp_path / "model.yaml", f"{HOSTILE}\nrobot: other\x00.xml\x85x: y")
    again = read_model(tmp_path / "model.yaml")
    assert again.effects == model.effects
    (one,) = again.formulas
    assert (one.law, one.text, one.ratio) == (law, "a * x", 0.3)
    assert one.constants["a"].unit == HOSTILE
    checked(tmp_path)


FORMULA = {
    "robot": "pendulum.xml",
    "effects": {"formula_torque_hinge_position": {"a": {"hinge": 0.1}}},
    "formulas": [
        {"kind": "torque", "joint": "hinge", "follows": "position", "formula": "a * x",
         "constants": {"a": {"unit": "N·m/rad", "lower": -1, "upper": 1}}},
    ],
}  # fmt: skip


@pytest.mark.parametrize(
    ("keys", "value", "message"),
    [
        (("formula",), "__import__('os').system('touch X')", "formulas.0.formula: found"),
        (("formula",), "(lambda: a * x)()", "formulas.0.formula: found"),
        (("formula",), "a.__class__ * x", "formulas.0.formula: found"),
        (("formula",), "a * x if x else 0", "formulas.0.formula: found"),
        (("formula",), "a * x +", "which is no formula"),
        (("formula",), f"a * x + 1{'0' * 400}", "which is no formula"),
        (("formula",), "a * y", "'y'; allowed: numbers, names"),
        (("formula",), "eval(a)", "'eval\\(a\\)'; allowed"),
        (("formula",), f"a * x{' + x' * 200}", "characters; allowed: at most 500"),
        (("formula",), "x", "constants: found a, which the formula does not use"),
        (("constants",), {"exp": {"lower": 0, "upper": 1}}, "found the name 'exp'"),
        (("constants",), {"a": {"lower": 1, "upper": 1}}, "lower below upper"),
        (("kind",), "inertia", "formulas.0.kind"),
        (("kind",), "limit", "formulas.0.follows: found 'position'; allowed for limit: velocity"),
        (("joint",), "elbow", "unknown effect 'formula_torque_hinge"),
    ],
)
def test_a_formula_that_is_none_is_refused(tmp_path, keys, value, message):
    pendulum(tmp_path)
    content = json.loads(json.dumps(FORMULA))
    (key,) = keys
    content["formulas"][0][key] = value
    (tmp_path / "model.yaml").write_text(yaml.safe_dump(content))
    with pytest.raises(ConfigurationError, match=message):
        read_model(tmp_path / "model.yaml")
    checked(tmp_path)


def test_a_formula_that_drives_a_motor_backwards_is_refused(tmp_path):
    pendulum(tmp_path)
    name = "formula_limit_hinge_velocity"
    content = FORMULA | {"effects": {name: {"a": {"hinge": -0.1}}}}
    limit = {"kind": "limit", "follows": "velocity", "formula": "a - x"}
    content["formulas"] = [FORMULA["formulas"][0] | limit]
    (tmp_path / "model.yaml").write_text(yaml.safe_dump(content))
    with pytest.raises(ConfigurationError, match=r"a limit of -0\.1 N·m at rest"):
        read_model(tmp_path / "model.yaml")


def test_a_formula_is_evaluated_as_python_would():
    x = np.linspace(-2, 2, 9)
    text, values = "a * sin(b * x + 1) - abs(x)**2 / (2 - -c) + exp(-x)", {"a": 2, "b": 3, "c": 0.5}
    expected = 2 * np.sin(3 * x + 1) - np.abs(x) ** 2 / 2.5 + np.exp(-x)
    np.testing.assert_allclose(evaluate(parse(text, values), x, values), expected)
    # whole numbers of Python would grow until memory ends
    assert np.isinf(evaluate(parse("9**9**9**9", ()), np.ones(2), {})).all()


@pytest.fixture
def received(tmp_path, monkeypatch):
    """A folder from elsewhere: a model that names Python, which would leave a file X."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv(registry.TRUST, raising=False)
    robot = pendulum(tmp_path)
    text = f"open({str(tmp_path / 'X')!r}, 'w').close()\n{RUBBER}"
    (tmp_path / "rubber.py").write_text(text)
    content = {"robot": "pendulum.xml", "effect_files": ["rubber.py"]}
    content["effects"] = {"rubber": {"stiffness": {"hinge": 0.1}}}
    (tmp_path / "model.yaml").write_text(yaml.safe_dump(content))
    (tmp_path / "models").mkdir()
    shutil.copy("model.yaml", "models/rubber.yaml")
    (tmp_path / "models/rubber.yaml").write_text(yaml.safe_dump(content | {
        "robot": "../pendulum.xml", "effect_files": ["../rubber.py"],
    }))  # fmt: skip
    (tmp_path / "diagnosis.json").write_text(json.dumps({"ranking": [{"effect": "rubber"}]}))
    for log in swings(robot, duration_s=0.3):
        write_recording(log, tmp_path / "logs" / log.name)
    return tmp_path


LOOP = ["--kp", "9", "--kd", "1", "--control-rate-hz", "500", "--gravity-compensation", "no"]
COMMANDS = [
    ["compare", "logs", "--model", "model.yaml", "--out", "out"],
    ["diagnose", "logs", "--model", "model.yaml", "--out", "out"],
    ["explain", "logs", "--model", "model.yaml", "--out", "out"],
    ["propose", "logs", "--model", "model.yaml", "--out", "out"],
    ["check", "logs", "--model", "model.yaml"],
    ["export", "model.yaml", *LOOP, "--out", "out"],
    ["adopt", "rubber", "--diagnosis", ".", "--out", "new.yaml"],
]


@pytest.mark.parametrize("command", COMMANDS, ids=lambda command: command[0])
def test_python_that_a_model_names_runs_only_if_the_person_says_so(received, capsys, command):
    with pytest.raises(SystemExit) as ended:
        main(command)
    assert "effect_files: found" in str(ended.value)
    assert str(received / "rubber.py") in str(ended.value)
    assert "--trust" in str(ended.value)
    checked(received)


@pytest.mark.parametrize("said", [["--trust"], ["--effects", "rubber.py"]])
def test_then_it_runs(received, said):
    main(["adopt", "rubber", "--diagnosis", ".", "--out", "new.yaml", *said])
    assert (received / "X").exists()
    assert registry.untrusted([received / "rubber.py"]), "trust outlives the command"


def test_steps_from_elsewhere_run_no_python_that_the_run_does_not_have(received):
    """A folder that explain goes on in may have come from anywhere."""
    from t2l.identify.model import read_again

    with pytest.raises(ConfigurationError, match="Python that would run"):
        read_again(received / "models/rubber.yaml", Model(str(received / "pendulum.xml")))
    assert not (received / "X").exists()


def test_extensions_of_a_configuration_run_only_if_the_person_says_so(received):
    from t2l.config import read_study
    from tests.conftest import ROOT, configuration

    config = configuration("config") | {"extensions": ["rubber.py"]}
    config["diagnosis"] = {"recordings": ["logs"], "effects": ["rubber.py"]}
    for key in ("extensions", "diagnosis.effects"):
        with pytest.raises(ConfigurationError, match="Python that would run") as error:
            read_study(config, ROOT / "config")
        assert f"config: {key}" in str(error.value)
        config.pop("extensions", None)
    assert not (received / "X").exists()


def test_lerobot_runs_extensions_of_its_command_line_only(monkeypatch):
    """A folder, a type or an output that the command names besides is no consent."""
    from lerobot_env_t2l.config import _named_in_command

    command = ["lerobot-eval", "--config_path=received", "--env.type=t2l", "--output_dir=."]
    for given, named in (
        ([], set()),
        (["--env.extensions=[mine.py, a/b.py]"], {"mine.py", "a/b.py"}),
        (["--env.extensions", "['mine.py']"], {"mine.py"}),
    ):
        monkeypatch.setattr("sys.argv", [*command, *given])
        assert _named_in_command() == named


@pytest.mark.parametrize("path", ["diagnosis", "diagnosis/before"])
def test_a_link_in_results_of_the_workflow_is_not_written_through(tmp_path, path):
    (tmp_path / "theirs").mkdir()
    link = tmp_path / "results" / path
    link.parent.mkdir(parents=True)
    link.symlink_to(tmp_path / "theirs")
    (tmp_path / f"results/{MARK}").write_text('{"command": "snakemake", "entries": []}')
    with pytest.raises(OutputError, match="is a link"):
        claim(tmp_path / "results", "snakemake")
    link.unlink()
    # its own, such as the last of some checkpoints
    link.symlink_to("seed0")
    os.close(claim(tmp_path / "results", "snakemake"))


def test_a_mark_that_is_somebodys_file_is_left_alone(tmp_path):
    (tmp_path / "mine").write_text("mine")
    (tmp_path / "out").mkdir()
    os.link(tmp_path / "mine", tmp_path / f"out/{MARK}")
    with pytest.raises(OutputError, match="file of two names"), \
            output_folder(tmp_path / "out", "t2l test", ["a"]):  # fmt: skip
        pass
    assert (tmp_path / "mine").read_text() == "mine"


@pytest.mark.parametrize(
    ("element", "said"),
    [
        ('<asset><texture name="t" type="2d" builtin="flat" width="60000" height="60000"/></asset>',
         "width and height: found 3.6e\\+09 in all"),
        ('<asset><hfield name="h" nrow="40000" ncol="40000" size="1 1 1 1"/></asset>', "nrow and"),
        ('<worldbody><replicate count="300000"><body/></replicate></worldbody>', "count: found"),
        ("<worldbody>" + "<body>" * 3000 + "</body>" * 3000 + "</worldbody>", "too many levels"),
    ],
)  # fmt: skip
def test_a_small_robot_file_takes_no_large_memory(tmp_path, element, said):
    path = Path(pendulum(tmp_path))
    path.write_text(path.read_text().replace("<worldbody>", f"{element}<worldbody>", 1))
    with pytest.raises(ConfigurationError, match=said):
        plant.read(str(path))


def test_a_small_table_takes_no_large_memory(tmp_path, monkeypatch):
    monkeypatch.setattr(documents, "MOST_CELLS", 50)
    log = swings(pendulum(tmp_path), duration_s=0.3)[0]
    write_recording(log, tmp_path / "log", "parquet")
    with pytest.raises(RecordingError, match="31 rows of"):
        read_recordings([tmp_path / "log.parquet"])


def test_pipes_are_found_wherever_mujoco_may_look(tmp_path):
    (tmp_path / "m").mkdir()
    (tmp_path / "inc.xml").write_text(
        '<mujoco><asset><mesh name="m" file="gone/pipe.stl"/></asset></mujoco>'
    )
    os.mkfifo(tmp_path / "m/pipe.stl")
    path = tmp_path / "robot.xml"
    path.write_text(
        '<mujoco><compiler meshdir="m" strippath="true"/><include file="inc.xml"/><worldbody/>'
        "</mujoco>"
    )
    with pytest.raises(ConfigurationError, match="pipe"):
        plant.read(str(path))


def test_names_steer_no_terminal(received, capsys):
    evil = "x\x1b[2K\r.py"
    (received / evil).write_text("open('X', 'w')")
    content = yaml.safe_load((received / "model.yaml").read_text())
    (received / "model.yaml").write_text(yaml.safe_dump(content | {"effect_files": [evil]}))
    with pytest.raises(SystemExit) as ended:
        main(["compare", "logs", "--model", "model.yaml", "--out", "out"])
    assert "\x1b" not in str(ended.value)
    assert "x\\x1b[2K\\r.py" in str(ended.value)
    with printable():
        print("a\x1b[31mb\tc")
    assert capsys.readouterr().out == "a\\x1b[31mb\tc\n"


@pytest.mark.parametrize("name", ["a\nb", "a\x1b[2J"])
def test_a_joint_name_that_is_no_line_of_text_is_refused(tmp_path, name):
    log = swings(pendulum(tmp_path), duration_s=0.3)[0]
    write_recording(dataclasses.replace(log, joints=("odd",)), tmp_path / "log")
    for path in (tmp_path / "log.yaml", tmp_path / "log.csv"):
        path.write_text(path.read_text().replace("odd", "hinge"))
    content = yaml.safe_load((tmp_path / "log.yaml").read_text())
    (tmp_path / "log.yaml").write_text(yaml.safe_dump(content | {"joints": [name]}))
    with pytest.raises(RecordingError, match="key joints"):
        read_recordings([tmp_path / "log.yaml"])
