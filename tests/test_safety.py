"""Nothing of the user's lost, nothing silently stale, nothing outside the folder asked for."""

import json
import logging
import os
import shutil
import signal
import socket
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
import yaml

from t2l.cli.main import main
from t2l.diagnose.fingerprint import fingerprint_of
from t2l.diagnose.recordings_and_model import read_recordings_and_model
from t2l.hardware.recorder import write_or_keep
from t2l.identify.prediction import Predictor
from t2l.outputs import MARK, output_folder
from t2l.recordings import write_recording
from t2l.robots import plant
from tests.diagnose.made import recording, swings
from tests.effects.test_registry import RUBBER
from tests.fuzz.harness import snapshot
from tests.fuzz.test_plans import PLAN

BODY = """<mujocoinclude><body pos="0 0 1">
  <joint name="hinge" axis="0 1 0" armature="0.005" damping="0.02"/>
  <geom type="mesh" mesh="bob" density="500"/></body></mujocoinclude>"""
ROBOT = """<mujoco><compiler angle="radian" meshdir="meshes"/>
  <asset><mesh name="bob" file="bob.obj"/></asset>
  <worldbody>{float}<include file="arm.xml"/></worldbody></mujoco>"""


def tetrahedron(size):
    corners = size * np.array([[0, 0, -1], [1, 0, -3], [0, 1, -3], [-1, -1, -3]])
    lines = [f"v {x} {y} {z}" for x, y, z in corners]
    return "\n".join([*lines, "f 1 2 3", "f 1 3 4", "f 1 4 2", "f 2 4 3"])


@pytest.fixture
def home(tmp_path, monkeypatch):
    """A robot of several files, an effect of one's own, and recordings."""
    (tmp_path / "meshes").mkdir()
    (tmp_path / "meshes/bob.obj").write_text(tetrahedron(0.1))
    (tmp_path / "arm.xml").write_text(BODY)
    (tmp_path / "robot.xml").write_text(ROBOT.format(float=""))
    (tmp_path / "rubber.py").write_text(RUBBER)
    robot = str(tmp_path / "robot.xml")
    for made in swings(robot, {}, duration_s=0.4, control_rate_hz=125.0):
        write_recording(made, tmp_path / "logs" / made.name)
    (tmp_path / "model.yaml").write_text(yaml.safe_dump({"robot": "robot.xml"}))
    monkeypatch.chdir(tmp_path)
    return tmp_path


def refused(*arguments):
    """What a command says that changes nothing at all."""
    before = snapshot(Path.cwd())
    with pytest.raises(SystemExit) as caught:
        main(list(arguments))
    assert isinstance(caught.value.code, str)
    assert snapshot(Path.cwd()) == before
    return caught.value.code


def test_a_folder_is_never_replaced_by_a_file(home):
    Path("mine.yaml").mkdir()
    Path("mine.yaml/thesis.tex").write_text("years of work")
    Path("found/models").mkdir(parents=True)
    Path("found/models/sketch.yaml").write_text("mine")
    Path("found/diagnosis.json").write_text('{"ranking": [{"effect": "armature"}]}')
    Path("found/models/armature.yaml").write_text("robot: ../../robot.xml\n")
    # the file of a diagnosis that lacks the effect it is called by
    assert "allowed: a model with armature" in refused(
        "adopt", "armature", "--diagnosis", "found", "--out", "new.yaml"
    )
    Path("found/models/armature.yaml").write_text(
        "robot: ../../robot.xml\neffects: {armature: {inertia: {hinge: 0.1}}}\n"
    )
    adopt = ["adopt", "armature", "--diagnosis", "found", "--out"]
    for force in ([], ["--force"]):
        assert "is a folder" in refused(*adopt, "mine.yaml", *force)
    Path("out/comparison.json").mkdir(parents=True)
    Path("out/comparison.json/thesis.tex").write_text("years of work")
    for force in ([], ["--force"]):
        said = refused("compare", "logs", "--out", "out", *force)
        assert "out/comparison.json: is a folder where a file is to be written" in said
    assert "found: holds" in refused("diagnose", "logs", "--out", "found")


def test_a_file_of_the_users_in_a_folder_of_results_stays(home):
    line = ["diagnose", "logs", "--out", "found"]
    main(line)
    for name in ("found/models/sketch.yaml", "found/notes.txt", "found/figures/mine.png"):
        Path(name).write_text("mine")
    main(line)
    for name in ("found/models/sketch.yaml", "found/notes.txt", "found/figures/mine.png"):
        assert Path(name).read_text() == "mine"


def test_outputs_beside_inputs_are_refused(home):
    Path("logs/traces.csv").write_bytes(Path("logs/kp20.csv").read_bytes())
    Path("logs/traces.yaml").write_bytes(Path("logs/kp20.yaml").read_bytes())
    for force in ([], ["--force"]):
        assert "logs: is read by this command" in refused(
            "compare", "logs", "--out", "logs", *force
        )
    Path("work").mkdir()
    shutil.copy("model.yaml", "work/model.yaml")
    Path("work/model.yaml").write_text("robot: ../robot.xml\n")
    Path("work", MARK).write_text('{"command": "t2l explain", "entries": ["model.yaml"]}')
    for force in ([], ["--force"]):
        said = refused("explain", "logs", "--model", "work/model.yaml", "--out", "work", *force)
        assert "work/model.yaml: is read by this command" in said


def test_a_comparison_is_not_shown_as_an_older_diagnosis(home):
    Path("found").mkdir()
    Path("found", MARK).write_text(
        '{"command": "t2l diagnose", "entries": ["diagnosis.json", "models", "report.html"]}'
    )
    Path("found/diagnosis.json").write_text("{}")
    said = refused("compare", "logs", "--out", "found")
    assert "found: holds the results of t2l diagnose" in said
    main(["compare", "logs", "--out", "found", "--force"])
    assert not Path("found/diagnosis.json").exists()
    assert "The model is off by" in Path("found/report.html").read_text()


@pytest.mark.parametrize("command", ["compare", "explain"])
def test_several_runs_into_one_folder_do_not_mix(home, command):
    line = [sys.executable, "-m", "t2l", command, "logs", "--out", "together"]
    runs = [
        subprocess.Popen(line, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
        for _ in range(2)
    ]
    ended = [(run.communicate()[1], run.returncode) for run in runs]
    assert any(code == 0 for _, code in ended)
    for said, code in ended:
        assert "Traceback" not in said
        assert code == 0 or "together: another run is at work here" in said
    assert not [path for path in Path("together").rglob("*") if ".draft-" in path.name]


def test_what_a_step_depends_on_is_part_of_its_key(home):
    def key():
        model, recordings, _ = read_recordings_and_model(["logs"], (), None, [Path("rubber.py")])
        return fingerprint_of(model, "all", [Predictor(model.robot, recordings, threads=1)])

    keys = [key()]
    for path, old, new in (
        ("arm.xml", "0.02", "0.03"),
        ("meshes/bob.obj", "v 0.0 0.0 -0.1", "v 0.0 0.0 -0.2"),
        ("robot.xml", 'angle="radian"', 'angle="radian" boundmass="9"'),
        ("rubber.py", "0.01, 0.1", "0.01, 0.2"),
        ("logs/kp20.yaml", "kd: 0.8", "kd: 0.7"),
    ):
        text = Path(path).read_text()
        assert old in text
        Path(path).write_text(text.replace(old, new, 1))
        # MuJoCo keeps meshes within a process by their time of change, in whole seconds
        later = time.time() + 10 * len(keys)
        os.utime(path, (later, later))
        keys.append(key())
    assert len(set(keys)) == len(keys)
    assert key() == keys[-1]


def test_the_library_is_part_of_the_key(home, monkeypatch):
    model, recordings, _ = read_recordings_and_model(["logs"])
    depends = model, "all", [Predictor(model.robot, recordings, threads=1)]
    before = fingerprint_of(*depends)
    monkeypatch.setattr("t2l.diagnose.fingerprint.library", lambda: "t2l 99")
    assert fingerprint_of(*depends) != before


def test_a_robots_files_are_all_known(home):
    found = {path.name for path in plant.files(str(home / "robot.xml"))}
    assert found == {"robot.xml", "arm.xml", "bob.obj"}


def test_a_floating_base_is_told(home, caplog):
    text = (
        '<body><freejoint name="trunk"/><inertial pos="0 0 0" mass="9" diaginertia="1 1 1"/></body>'
    )
    Path("robot.xml").write_text(ROBOT.format(float=text))
    with caplog.at_level(logging.WARNING):
        read_recordings_and_model(["logs"])
    assert "the model floats by its free joint 'trunk'; it is held" in caplog.text


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("../../evil", "key name: found '../../evil'"),
        ("/tmp/evil", "key name"),
        ("x" * 5000, "key name"),
    ],
    ids=["above", "absolute", "long"],
)
def test_a_plan_never_records_outside_its_folder(home, name, said):
    Path("plan.yaml").write_text(yaml.safe_dump({**PLAN, "name": name}))
    message = refused("record", "plan.yaml", "--out", "out")
    assert said in message
    assert len(message) < 500


@pytest.mark.parametrize("out", ["file/out", "x" * 300, "robot.xml", "logs"])
def test_nothing_moves_where_a_recording_cannot_be_written(home, out, monkeypatch):
    Path("plan.yaml").write_text(yaml.safe_dump({**PLAN, "name": "kp20", "address": "simulation"}))
    Path("file").touch()
    monkeypatch.setattr("t2l.hardware.franka.connect", lambda *_: pytest.fail("it moved"))
    assert out in refused("record", "plan.yaml", "--out", out)


@pytest.mark.parametrize("suffix", [".csv", ".parquet", ".yaml"])
def test_recordings_that_are_there_stay(home, suffix, monkeypatch):
    Path("plan.yaml").write_text(yaml.safe_dump({**PLAN, "name": "first"}))
    monkeypatch.setattr("t2l.hardware.franka.connect", lambda *_: pytest.fail("it moved"))
    with output_folder("out", "t2l record", [f"first_kp64_kd4{suffix}"]):
        Path(f"out/first_kp64_kd4{suffix}").touch()
    said = refused("record", "plan.yaml", "--out", "out")
    assert f"out: first_kp64_kd4{suffix} there already; allowed: a folder or names" in said


def test_a_robot_that_does_not_answer_is_told_soon(home):
    # a port that is bound and does not listen refuses; the address is this machine's own
    Path("plan.yaml").write_text(yaml.safe_dump({**PLAN, "address": "127.0.0.1"}))
    started = time.monotonic()
    said = refused("record", "plan.yaml", "--out", "out", "--yes")
    assert "key address: found 127.0.0.1, which cannot be reached" in said
    assert time.monotonic() - started < 10


def test_an_address_that_swallows_everything_is_told_soon(home, monkeypatch):
    """A listener whose queue is full never answers, as an address that nobody has."""
    with socket.socket() as deaf:
        deaf.bind(("127.0.0.1", 0))
        deaf.listen(0)
        waiting = [socket.socket() for _ in range(3)]
        for each in waiting:
            each.setblocking(False)
            each.connect_ex(deaf.getsockname())
        monkeypatch.setattr("t2l.hardware.franka_connection.FCI_PORT", deaf.getsockname()[1])
        monkeypatch.setattr("t2l.hardware.franka_connection.ANSWER_S", 0.5)
        Path("plan.yaml").write_text(yaml.safe_dump({**PLAN, "address": "127.0.0.1"}))
        said = refused("record", "plan.yaml", "--out", "out", "--yes")
        for each in waiting:
            each.close()
    assert "cannot be reached (no answer)" in said


def test_without_a_terminal_nothing_moves(home):
    Path("plan.yaml").write_text(yaml.safe_dump({**PLAN, "address": "127.0.0.1"}))
    line = [sys.executable, "-m", "t2l", "record", "plan.yaml", "--out", "out"]
    done = subprocess.run(line, stdin=subprocess.DEVNULL, capture_output=True, text=True)
    assert done.returncode == 1
    assert (
        "nobody is there to say that the FR3 at 127.0.0.1 may move; allowed: a terminal, or --yes"
        in done.stderr
    )
    assert not Path("out").exists()


def test_a_recording_that_could_not_be_written_is_kept_elsewhere(home, monkeypatch):
    made = recording(str(home / "robot.xml"), np.sin)
    monkeypatch.setenv("TMPDIR", str(home))
    monkeypatch.setattr("tempfile.tempdir", None)
    Path("out").touch()
    with pytest.raises(Exception, match="the recording is kept as") as caught:
        write_or_keep(made, Path("out/made"))
    kept = Path(str(caught.value).rpartition("kept as ")[2])
    assert kept.exists()
    assert kept.is_relative_to(home)


def test_a_killed_explanation_ends_as_if_it_had_never_stopped(home, capsys):
    """At moments that are spread over the run."""

    def numbers(folder):
        return {
            str(path.relative_to(folder)): path.read_bytes()
            for path in sorted(Path(folder).rglob("*"))
            if path.suffix in (".json", ".yaml", ".parquet") and path.name != MARK
        }

    main(["explain", "logs", "--out", "whole"])
    lines = capsys.readouterr().err.count("\n")
    command = [sys.executable, "-m", "t2l", "explain", "logs", "--out", "killed"]
    for part in (0.25, 0.6, 0.9):
        run = subprocess.Popen(command, stderr=subprocess.PIPE)
        for _ in range(round(part * lines)):
            run.stderr.readline()
        run.send_signal(signal.SIGKILL)
        run.communicate()
    main(["explain", "logs", "--out", "killed"])
    assert numbers("killed") == numbers("whole")
    assert not [path for path in Path("killed").rglob("*") if ".draft-" in path.name]


@pytest.fixture
def small_disk(tmp_path):
    """A file system with hardly any room."""
    folder = tmp_path / "small"
    folder.mkdir()
    mounted = subprocess.run(
        ["mount", "-t", "tmpfs", "-o", "size=300k", "tmpfs", str(folder)], capture_output=True
    )
    if mounted.returncode:
        pytest.skip("only root may mount a file system")
    yield folder
    subprocess.run(["umount", "--lazy", str(folder)], check=True)


def test_a_full_disk_is_told_and_the_run_goes_on_when_there_is_room(home, small_disk):
    ballast = small_disk / "ballast"
    ballast.write_bytes(bytes(200_000))
    line = ["explain", "logs", "--out", "small/out"]
    with pytest.raises(SystemExit) as caught:
        main(line)
    assert f"No space left on device (the file system at {small_disk})" in caught.value.code
    finished = {p: p.read_bytes() for p in (small_disk / "out/steps").rglob("*") if p.is_file()}
    assert not [path for path in small_disk.rglob("*") if ".draft-" in path.name]
    ballast.unlink()
    subprocess.run(["mount", "-o", "remount,size=100m", str(small_disk)], check=True)
    main(line)
    assert {p: p.read_bytes() for p in finished} == finished
    assert json.loads((small_disk / "out/explanation.json").read_text())["steps"]
