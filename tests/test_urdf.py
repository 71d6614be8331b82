"""From a CSV and a URDF to a robot in plain MuJoCo, by the command line alone."""

import json

import mujoco
import numpy as np
import pandas as pd
import pytest
import yaml

from t2l.cli.main import main
from t2l.effects.registry import builtin
from t2l.export.agreement import replay
from t2l.recordings.log import read_recordings
from tests.diagnose.made import measured, recording, step, swing
from tests.robots.test_plant import URDF

KP, KD, RATE_HZ = 20.0, 0.8, 250
MAPPING = {
    "robot": "arm.urdf", "joints": ["shoulder"], "kp": KP, "kd": KD, "command_rate_hz": 100,
    "control_rate_hz": RATE_HZ, "gravity_compensation": False,
    "columns": {
        "time": {"from": "stamp", "unit": "ms"},
        "q_des": {"from": ["goal"], "unit": "deg"},
        "q": {"from": ["angle"], "unit": "deg"},
    },
}  # fmt: skip
HIDDEN = {"coulomb_friction": {"torque": {"shoulder": 0.6}}}
KNOWN = ("coulomb_friction", "viscous_friction")


def tables(folder, urdf=URDF, effects=HIDDEN, kd=KD):
    """A URDF, a mapping, and what the robot with `effects` did, as others would write it."""
    (folder / "arm.urdf").write_text(urdf)
    (folder / "mapping.yaml").write_text(yaml.safe_dump({**MAPPING, "kd": kd}))
    for i, commands in enumerate((swing(0.5, 0.8), swing(0.4, 1.3), step(0.6))):
        made = recording(
            str(folder / "arm.urdf"), commands, kp=KP, kd=kd, joints=("shoulder",),
            control_rate_hz=float(RATE_HZ),
        )  # fmt: skip
        log = measured(made, effects, noise_rad=1e-4, seed=i)
        degrees = np.rad2deg(np.column_stack([log.q_des, log.q]))
        table = pd.DataFrame(
            {"stamp": 1e3 * log.time, "goal": degrees[:, 0], "angle": degrees[:, 1]}
        )
        table.to_csv(folder / f"run_{i}.csv", index=False)
    return [f"run_{i}.csv" for i in range(3)]


def test_from_csv_and_urdf_to_plain_mujoco(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    runs = tables(tmp_path)
    main(["import-csv", "mapping.yaml", *runs, "--out", "logs"])
    others = [word for name in builtin() if name not in KNOWN for word in ("--without", name)]
    main(["explain", "logs", "--out", "found", *others])
    main(["export", "found/model.yaml", "--logs", "logs", "--out", "exported"])
    assert (
        "coulomb_friction" in yaml.safe_load((tmp_path / "found/model.yaml").read_text())["effects"]
    )
    # nothing of t2l from here on
    model = mujoco.MjModel.from_xml_path(str(tmp_path / "exported/model.xml"))
    assert [model.joint(i).name for i in range(model.njnt)] == ["shoulder"]
    friction = model.dof_frictionloss[0] + model.tendon_frictionloss.sum()
    assert friction == pytest.approx(0.7, rel=0.1)  # 0.1 of it is the URDF's
    np.testing.assert_allclose(model.body("upper").inertia, [4e-3, 4e-3, 1e-4])
    np.testing.assert_array_equal(model.jnt_actfrcrange, [[-30, 30]])
    for log in read_recordings([tmp_path / "logs"]):
        q = replay(tmp_path / "exported", log)  # by MuJoCo and robot.py alone
        assert np.sqrt(np.mean((q - log.q) ** 2)) < 2e-3


def light(folder):
    """The same arm with a rotor that its URDF cannot hold, in logs of a folder."""
    urdf = URDF.replace('value="0.6"', 'value="0.01"').replace("4e-3", "1e-5")
    urdf = urdf.replace("1e-4", "1e-5")
    effects = {"armature": {"inertia": {"shoulder": 0.02}}}
    runs = tables(folder, urdf.replace('friction="0.1"', ""), effects, kd=0.3)
    main(["import-csv", "mapping.yaml", *runs, "--out", "logs"])


@pytest.fixture
def chattering(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    light(tmp_path)
    return tmp_path


@pytest.mark.parametrize(
    "command",
    [
        ["explain", "logs"],
        ["diagnose", "logs"],
        ["propose", "logs"],
        ["check", "logs", "--model", "model.yaml"],
        ["export", "model.yaml", "--logs", "logs"],
    ],
    ids=lambda command: command[0],
)
def test_a_model_that_chatters_is_not_fitted(chattering, command):
    (chattering / "model.yaml").write_text(
        "robot: arm.urdf\neffects: {viscous_friction: {damping: {shoulder: 0.001}}}\n"
    )
    with pytest.raises(
        SystemExit, match=r"chatters at its own rate on joint shoulder.*armature: \{"
    ):
        main([*command, "--out", "out"])
    assert not (chattering / "out").exists()


def test_compare_says_so_first_and_on_the_page(chattering, caplog):
    main(["compare", "logs", "--out", "out"])
    (said,) = [r.getMessage() for r in caplog.records if "chatters" in r.getMessage()]
    assert "Kd·h/M is" in said
    content = json.loads((chattering / "out/comparison.json").read_text())
    assert content["sentence"].startswith(said)
    assert "chatters at its own rate" in (chattering / "out/report.html").read_text()


def test_with_the_line_of_yaml_that_it_gives_it_is_fitted(chattering, caplog):
    main(["compare", "logs", "--out", "out"])
    (said,) = [r.getMessage() for r in caplog.records if "chatters" in r.getMessage()]
    line = said[said.index("effects: {") :]
    (chattering / "model.yaml").write_text(f"robot: arm.urdf\n{line}\n")
    caplog.clear()
    main(["compare", "logs", "--model", "model.yaml", "--out", "better"])
    assert not caplog.records
    main(["check", "logs", "--model", "model.yaml", "--out", "checked"])
