import json
from dataclasses import replace

import numpy as np
import pytest

from t2l.cli.main import main
from t2l.recordings import write_recording
from tests.diagnose.made import measured, pendulum, recording, swing

GAINS = ["--kp", "1", "--kd", "1", "--control-rate-hz", "1000", "--gravity-compensation", "no"]


@pytest.fixture(scope="module")
def home(tmp_path_factory):
    """A model, a log of its machine and one of it after a year."""
    home = tmp_path_factory.mktemp("home")
    robot = pendulum(home)
    for name, damping in (("old", 0.1), ("new", 0.2)):
        log = recording(robot, swing(0.5, 0.8), name, control_rate_hz=250.0)
        effects = {"viscous_friction": {"damping": {"hinge": damping}}}
        write_recording(measured(log, effects, 1e-4), home / name)
    (home / "model.yaml").write_text(
        "robot: pendulum.xml\neffects:\n  viscous_friction:\n    damping: {hinge: 0.1}\n"
    )
    still = np.zeros_like(log.q)
    write_recording(replace(log, q_des=still, q=still, dq=None, tau=None), home / "still")
    (home / "bare.yaml").write_text("robot: pendulum.xml\neffects: {}\n")
    return home


def test_check_says_what_has_drifted(home, tmp_path, capsys):
    arguments = ["check", str(home / "new.csv"), "--model", str(home / "model.yaml")]
    main([*arguments, "--reference", str(home / "old.csv"), "--out", str(tmp_path / "out")])
    said = capsys.readouterr().out
    assert "viscous_friction: drifted" in said
    assert "Drifted: viscous_friction." in said
    content = json.loads((tmp_path / "out/check.json").read_text())
    (change,) = content["effects"][0]["changes"]
    assert change["interval"][0] < 0.2 < change["interval"][1]
    main(["check", str(home / "old.csv"), "--model", str(home / "model.yaml")])
    assert "No adopted effect has drifted." in capsys.readouterr().out


def test_export_with_recordings_says_how_far_it_is(home, tmp_path, capsys):
    out = tmp_path / "out"
    main(["export", str(home / "model.yaml"), "--logs", str(home / "old.csv"), "--out", str(out)])
    assert "In the MJCF: viscous_friction" in capsys.readouterr().out
    content = json.loads((out / "export.json").read_text())
    assert content["from_t2l_rad"] < 3e-4  # steps of 4 ms, where t2l takes 1 ms
    assert content["ranges"]["mjmodel"][0]["field"] == "dof_damping"


def test_export_without_recordings(home, tmp_path):
    out = tmp_path / "out"
    options = ["--kp", "20", "--kd", "1", "--control-rate-hz", "1000"]
    main(["export", str(home / "model.yaml"), *options, "--gravity-compensation", "no", "--out",
          str(out)])  # fmt: skip
    assert json.loads((out / "export.json").read_text())["ranges"] is None


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["check", "new.csv", "--model", "bare.yaml"], "effects: found none"),
        (["check", "new.csv", "--model", "model.yaml", "--reference", "new.csv"],
         "new.csv: --reference: found a recording that is also given as LOG; allowed"),
        (["check", "still.csv", "--model", "model.yaml"], "the same number in every row"),
        (["check", "none.csv", "--model", "model.yaml"], "none"),
        (["export", "model.yaml", "--joints", "knee,hinge", *GAINS],
         "--joints: found 'knee'; allowed: different ones of hinge"),
        (["export", "model.yaml", "--joints", "hinge,hinge", *GAINS], "--joints: found 'hinge'"),
        (["export", "model.yaml", "--kp", "20"], "--kd: found nothing"),
        (["export", "model.yaml", "--logs", "new.csv", "--kp", "20"], "--kp: found it with --logs"),
        (
            ["export", "model.yaml", "--kp", "1,2", "--kd", "1", "--control-rate-hz", "1000",
             "--gravity-compensation", "no"],
            "--kp: found [1.0, 2.0]; allowed",
        ),
        (
            ["export", "model.yaml", "--kp", "1", "--kd", "1", "--control-rate-hz", "0",
             "--gravity-compensation", "no"],
            "--control-rate-hz: found 0",
        ),
    ],
)  # fmt: skip
def test_what_is_wrong_is_said_first(home, tmp_path, monkeypatch, arguments, said):
    monkeypatch.chdir(home)
    with pytest.raises(SystemExit) as caught:
        main([*arguments, "--out", str(tmp_path / "out")])
    assert said in str(caught.value.code)
    assert not (tmp_path / "out").exists()
