"""The commands as people type them; what they compute is tested where it is computed."""

import json
import subprocess
import sys

import numpy as np
import pytest

from t2l.cli.inputs import long_work
from t2l.cli.main import COMMANDS, main
from t2l.effects.registry import builtin
from t2l.identify.model import read_model
from t2l.recordings import write_recording
from tests.diagnose.made import pendulum, recording, swing, swings
from tests.effects.test_registry import RUBBER
from tests.made_extension import write_robot

COULOMB = {"coulomb_friction": {"torque": {"hinge": 0.05}}}


@pytest.fixture(scope="module")
def home(tmp_path_factory):
    """A folder with a robot, logs of it, and other logs that are wrong."""
    home = tmp_path_factory.mktemp("home")
    robot = pendulum(home, 'armature="0.005" damping="0.02" range="-2 2" limited="true"')
    for made in swings(robot, COULOMB, duration_s=0.5, control_rate_hz=125.0):
        write_recording(made, home / "logs" / made.name)
    made = recording(robot, lambda t: np.rad2deg(swing()(t)), "turned")
    write_recording(made, home / "degrees" / "turned")
    (home / "empty").mkdir()
    (home / "rubber.py").write_text(RUBBER)
    (home / "bad_model.yaml").write_text(
        "robot: pendulum.xml\neffects:\n  command_delay:\n    delay: soon\n"
    )
    return home


@pytest.fixture
def at_home(home, monkeypatch):
    monkeypatch.chdir(home)
    return home


@pytest.fixture(scope="module")
def diagnosed(home):
    main(["diagnose", str(home / "logs"), "--out", str(home / "found")])
    return home / "found"


@pytest.fixture(scope="module")
def plain(home):
    """The error of the MJCF as it is."""
    main(["compare", str(home / "logs"), "--out", str(home / "plain")])
    return json.loads((home / "plain/comparison.json").read_text())["rmse_q_rad"]


def fails(capsys, *arguments):
    """What a command that ends in an error says."""
    with pytest.raises(SystemExit) as caught:
        main(list(arguments))
    assert caught.value.code not in (0, None)
    captured = capsys.readouterr()
    said = caught.value.code if isinstance(caught.value.code, str) else captured.err
    assert "Traceback" not in said
    return said


def test_effects_lists_them_all_with_units_and_bounds(capsys):
    main(["effects"])
    said = capsys.readouterr().out
    for name, effect in builtin().items():
        assert f"\n{name}\n" in f"\n{said}"
        for parameter in effect.parameters:
            assert f"{parameter.name} [{parameter.unit}]" in said
        assert effect.source in said


def test_effects_shows_only_those_asked_for_and_ones_own(capsys, at_home):
    main(["effects", "rubber", "armature", "--effects", "rubber.py"])
    said = capsys.readouterr().out
    assert "A cord that pulls the joint back to zero." in said
    assert "armature" in said
    assert "backlash" not in said


def test_an_unknown_effect_is_named(capsys):
    said = fails(capsys, "effects", "rubbr")
    assert "rubbr" in said
    assert "armature" in said


def test_from_a_shell():
    """The module runs by itself, and a mistake is a message and an exit code."""
    command = [sys.executable, "-m", "t2l", "compare", "nowhere", "--out", "x"]
    bad = subprocess.run(command, capture_output=True, text=True)
    assert bad.returncode == 1
    assert bad.stderr.startswith("t2l compare: nowhere")
    assert "Traceback" not in bad.stderr


def test_a_reader_that_stops_early_is_no_error():
    line = f"{sys.executable} -m t2l effects | head -1"
    done = subprocess.run(line, shell=True, capture_output=True, text=True)
    assert done.stdout.rstrip() in builtin()
    assert done.stderr == ""


def test_without_a_command_they_are_listed(capsys):
    fails(capsys)
    with pytest.raises(SystemExit):
        main(["--help"])
    said = capsys.readouterr().out
    for name, command in COMMANDS.items():
        assert name in said
        assert command.HELP in " ".join(said.split())


def test_diagnose_tells_what_is_missing(diagnosed):
    content = json.loads((diagnosed / "diagnosis.json").read_text())
    assert content["verdict"] == "missing_effect"
    assert content["ranking"][0]["effect"] == "coulomb_friction"
    assert (diagnosed / "report.html").exists()


def test_adopt_writes_a_model_that_compare_takes(diagnosed, plain, at_home):
    main(["adopt", "coulomb_friction", "--diagnosis", "found", "--out", "models/better.yaml"])
    model = read_model("models/better.yaml")
    assert model.effects["coulomb_friction"]["torque"]["hinge"] == pytest.approx(0.05, rel=0.1)
    assert model.robot == str(at_home / "pendulum.xml")
    main(["compare", "logs", "--model", "models/better.yaml", "--out", "better"])
    better = json.loads((at_home / "better/comparison.json").read_text())["rmse_q_rad"]
    assert better < 0.4 * plain


def test_adopt_takes_several_effects(diagnosed, at_home):
    names = ["coulomb_friction", "command_delay"]
    main(["adopt", *names, "--diagnosis", "found", "--out", "both.yaml"])
    both = read_model("both.yaml")
    assert list(both.effects) == names
    for name in names:
        alone = read_model(f"found/models/{name}.yaml")
        assert both.effects[name] == alone.effects[name]


def test_adopt_names_an_effect_that_the_diagnosis_lacks(diagnosed, at_home, capsys):
    said = fails(capsys, "adopt", "coulomb_friction", "rubber", "--diagnosis", "found",
                 "--out", "never.yaml")  # fmt: skip
    assert "rubber" in said
    assert "coulomb_friction" in said
    assert not (at_home / "never.yaml").exists()


@pytest.mark.parametrize("folder", ["empty", "nowhere", "logs"])
def test_adopt_names_a_folder_without_a_diagnosis(at_home, capsys, folder):
    said = fails(capsys, "adopt", "armature", "--diagnosis", folder, "--out", "never.yaml")
    assert f"--diagnosis {folder}" in said
    assert not (at_home / "never.yaml").exists()


@pytest.mark.parametrize("command", ["compare", "diagnose", "explain"])
@pytest.mark.parametrize(
    ("arguments", "named"),
    [
        (["nowhere"], ["nowhere"]),
        (["empty"], ["empty", "no recording"]),
        (["degrees"], ["turned.csv", "q_des.hinge", "degrees"]),
        (["logs", "--model", "nowhere.yaml"], ["nowhere.yaml"]),
        (["logs", "--model", "bad_model.yaml"], ["bad_model.yaml", "command_delay.delay", "soon"]),
        (["logs", "--effects", "nowhere.py"], ["nowhere.py"]),
    ],
    ids=lambda value: value[-1] if value[0][0] != "t" else "",
)
def test_a_mistake_is_told_with_file_and_key_and_nothing_is_written(
    at_home, capsys, command, arguments, named
):
    before = {p for p in at_home.rglob("*")}
    said = fails(capsys, command, *arguments, "--out", "never")
    for word in named:
        assert word in said
    assert {p for p in at_home.rglob("*")} == before


def test_a_robot_of_ones_own_is_known_by_its_name(plain, at_home, capsys):
    write_robot(at_home / "mine.py", "pendulum_at_home")
    for path in (at_home / "logs").iterdir():
        text = path.read_text().replace("../pendulum.xml", "pendulum_at_home")
        (at_home / "named").mkdir(exist_ok=True)
        (at_home / "named" / path.name).write_text(text)
    said = fails(capsys, "compare", "named", "--out", "never")
    assert "key robot: found 'pendulum_at_home'" in said
    main(["compare", "named", "--extensions", "mine.py", "--out", "own"])
    assert json.loads((at_home / "own/comparison.json").read_text())["rmse_q_rad"] == plain


@pytest.mark.parametrize(
    "command", ["compare", "diagnose", "explain", "adopt", "record", "import-csv", "import-lerobot"]
)
def test_extensions_that_are_not_there_are_told(at_home, capsys, command):
    rest = {
        "adopt": ["armature", "--diagnosis", "found"],
        "record": ["plan.yaml"],
        "import-csv": ["mapping.yaml", "table.csv"],
        "import-lerobot": [
            *("set", "--robot", "fr3", "--joints", "a", "--kp", "1", "--kd", "1"),
            *("--control-rate-hz", "1", "--gravity-compensation", "yes"),
        ],
    }.get(command, ["logs"])
    said = fails(capsys, command, *rest, "--extensions", "nowhere.py", "--out", "never.yaml")
    assert f"t2l {command}: extension file {at_home / 'nowhere.py'}: no such file" in said


def test_an_out_that_is_a_file_is_told_before_any_work(at_home, capsys):
    """Not after minutes of fitting."""
    (at_home / "taken").write_text("mine")
    said = fails(capsys, "compare", "logs", "--out", "taken")
    assert "taken" in said
    assert (at_home / "taken").read_text() == "mine"


def test_holdout_may_be_repeated_and_not_be_fitted_too(at_home, capsys):
    said = fails(capsys, "diagnose", "logs", "--holdout", "logs/kp5", "--out", "never")
    assert "kp5" in said
    assert "--holdout" in said


@pytest.mark.parametrize(("second", "said"), [(0.1, ""), (1.0, "working, about 99 s")])
def test_only_long_work_is_announced_and_once(capsys, second, said):
    now = [0.0]
    report = long_work("working", lambda: now[0])
    # what is prepared before takes its own time
    now[0] = 30.0
    for part in range(1, 100):
        now[0] += second
        report(part / 100)
    told = capsys.readouterr().err
    assert said in told
    assert told.count("working") == bool(said)
