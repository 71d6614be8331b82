import json
import shutil

import pandas as pd
import pytest
import yaml

from t2l.cli.main import main
from tests.advise.made import ARM, dataset, motion
from tests.conftest import ROOT

TRAIN = ROOT / "examples/two_joint_arm/train"
SMALL = ("--kp", "3,12,50", "--kd", "0.1,0.5,2", "--policy-rate", "25")


def advise(*arguments):
    main(["advise", *map(str, arguments)])


def refused(capsys, *arguments):
    with pytest.raises(SystemExit) as ended:
        advise(*arguments)
    return str(ended.value)


@pytest.fixture(scope="module")
def shown(tmp_path_factory):
    return dataset(tmp_path_factory.mktemp("shown") / "set")


def test_an_mjcf_with_demonstrations(shown, tmp_path, capsys):
    advise(ARM, "--demonstrations", shown, *SMALL, "--out", tmp_path / "out")
    said = capsys.readouterr()
    assert "This takes about" in said.out
    assert "the best of what is left, for cloning" in said.out
    assert "replaying demonstrations" in said.err
    content = json.loads((tmp_path / "out/advice.json").read_text())
    gains = yaml.safe_load((tmp_path / "out/gains.yaml").read_text())["joints"]
    assert {name: (j["kp"], j["kd"]) for name, j in content["joints"].items()} == {
        name: (j["kp"], j["kd"]) for name, j in gains.items()
    }
    page = (tmp_path / "out/report.html").read_text()
    for part in ("What is ruled out, and why", "rank correlation", "data:image/png", "elbow"):
        assert part in page
    assert (tmp_path / "out/figures/maps.pdf").exists()
    assert not (tmp_path / "out/model.yaml").exists()


def test_a_urdf_and_nothing_else(tmp_path, capsys):
    (tmp_path / "one.urdf").write_text(
        """<robot name="one"><link name="base"/>
        <link name="arm"><inertial><origin xyz="0 0 -0.2"/><mass value="1"/>
        <inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial></link>
        <joint name="hinge" type="revolute"><parent link="base"/><child link="arm"/>
        <axis xyz="0 1 0"/><limit lower="-2" upper="2" effort="10" velocity="3"/></joint></robot>"""
    )
    advise(tmp_path / "one.urdf", "--out", tmp_path / "out")
    assert "damped critically" in capsys.readouterr().out
    assert "nothing tells how stiff" in (tmp_path / "out/report.html").read_text()


def test_a_model_of_the_machine_counts(tmp_path, capsys):
    (tmp_path / "model.yaml").write_text(
        f"robot: {ARM}\neffects:\n  torque_delay: {{delay: 0.018}}\n"
    )
    advise(ARM, "--model", tmp_path / "model.yaml", *SMALL, "--out", tmp_path / "out")
    assert "because torques and measurements come 18 ms late" in capsys.readouterr().out
    assert yaml.safe_load((tmp_path / "out/model.yaml").read_text())["effects"]["torque_delay"]


def test_effects_of_the_same_arm_without_its_hand_count(tmp_path, capsys):
    (tmp_path / "model.yaml").write_text("robot: fr3\neffects:\n  torque_delay: {delay: 0.004}\n")
    small = ("--kp", "50,200", "--kd", "5,40")
    advise("fr3_hand", "--model", tmp_path / "model.yaml", *small, "--out", tmp_path / "out")
    assert "come 4 ms late" in (tmp_path / "out/report.html").read_text()
    said = refused(capsys, "ur5e", "--model", tmp_path / "model.yaml", "--out", tmp_path / "no")
    assert "found fr3, which has no joint shoulder_pan_joint" in said


def test_nothing_is_left_of_a_run_that_fails(shown, tmp_path, capsys):
    out = tmp_path / "out"
    said = refused(
        capsys, ARM, "--no-gravity-compensation", "--kp", "0.5,1", "--kd", "0.3,0.5", "--out", out
    )
    assert "--kp, --kd: found no gains among Kp 0.5 to 1" in said
    assert "sags by up to" in said
    assert not out.exists()


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"joints": ("hip", "knee")}, "a data set of another robot says nothing"),
        ({"motions": lambda i, hz: 10 * motion(i, hz)}, "by the joint's range in the model"),
    ],
)
def test_demonstrations_of_another_robot_are_refused(tmp_path, capsys, change, message):
    other = dataset(tmp_path / "set", **change)
    said = refused(capsys, ARM, "--demonstrations", other, "--out", tmp_path / "out")
    assert message in said
    assert not (tmp_path / "out").exists()


@pytest.fixture
def still(tmp_path):
    """Recordings in which the elbow does not move."""
    folder = tmp_path / "still"
    shutil.copytree(TRAIN, folder)
    for path in folder.glob("*.csv"):
        table = pd.read_csv(path)
        for column in table.columns:
            if column.endswith(".elbow"):
                table[column] = table[column].iloc[0]
        table.to_csv(path, index=False)
    for path in folder.glob("*.yaml"):
        path.write_text(path.read_text().replace("../two_joint_arm.xml", ARM))
    return folder


def test_a_joint_of_which_recordings_say_nothing_is_named_with_what_to_record(
    still, tmp_path, capsys
):
    said = refused(capsys, ARM, "--logs", still, "--out", tmp_path / "out")
    assert "joint elbow: found no motion above 1 mrad" in said
    assert "t2l plan" in said


@pytest.mark.slow
def test_recordings_are_explained_first(tmp_path, capsys):
    out = tmp_path / "out"
    advise(ARM, "--logs", TRAIN, "--time", "10", *SMALL, "--out", out)
    assert "command_delay" in yaml.safe_load((out / "model.yaml").read_text())["effects"]
    assert json.loads((out / "advice.json").read_text())["effects"]


@pytest.mark.slow
def test_a_task_beyond_reach_is_refused(block_stack, tmp_path, capsys):
    far = {**block_stack, "workspace_x_m": [0.9, 1.0]}
    (tmp_path / "far.yaml").write_text(yaml.safe_dump(far))
    said = refused(capsys, "fr3_hand", "--task", tmp_path / "far.yaml", "--out", tmp_path / "out")
    assert "found a task that fr3_hand does not reach: " in said
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("--policy-rate", "0"), "--policy-rate: found 0; allowed: 1 to 1000"),
        (("--kp", "10"), "--kp and --kd: found one of them"),
        (("--kp", "-1", "--kd", "1"), "--kp: found [-1.0]; allowed: up to 30 numbers above 0"),
        (("--recorded-kp", "1", "--recorded-kd", "1"), "no --demonstrations; allowed: both"),
        (("--demonstrations", "a", "--task", "b"), "found both; allowed: one of them"),
        (("--joints", "hip"), "no hinge or slide joint named 'hip'"),
        (("--task", "none.yaml"), "none.yaml"),
    ],
)  # fmt: skip
def test_options_that_are_wrong_are_named(tmp_path, capsys, arguments, message):
    assert message in refused(capsys, ARM, *arguments, "--out", tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_a_policy_faster_than_demonstrations_is_refused(shown, tmp_path, capsys):
    said = refused(
        capsys, ARM, "--demonstrations", shown, "--policy-rate", "500", "--out", tmp_path / "out"
    )
    assert "--policy-rate: found 500 Hz; allowed: up to 100 Hz" in said


def test_time_ends_explaining_wherever_it_is(tmp_path, capsys):
    """In so short a time nothing is found: the machine counts as unknown."""
    logs, out = (TRAIN, tmp_path / "out")
    advise(ARM, "--logs", logs, "--time", 1, *SMALL[:4], "--out", out)
    said = capsys.readouterr().out
    assert "nothing was explained in that time" in said
    assert not (out / "model.yaml").exists()
    assert "Nothing of the real machine is known" in (out / "report.html").read_text()


def test_a_picture_of_the_loop_comes_first(tmp_path, capsys):
    advise(ARM, *SMALL[:4], "--out", tmp_path / "out")
    said = capsys.readouterr().out
    assert said.index("A first picture") < said.index("the best of what is left")
    assert (tmp_path / "out/figures/first.png").stat().st_size > 10_000


def test_for_reinforcement_alone_nothing_ranks_gains(shown, tmp_path, capsys):
    out, both = tmp_path / "out", ("--demonstrations", shown)
    advise(ARM, *both, *SMALL, "--for", "reinforcement", "--out", out)
    assert "damped critically" in capsys.readouterr().out
    page = (out / "report.html").read_text()
    assert "Nothing is known that ranks gains for learning by trying" in page
    assert "action scale [rad]" in page
    assert json.loads((out / "advice.json").read_text())["cells"][0]["predicted_error_rad"] is None


def test_for_cloning_alone_no_action_scales_are_told(shown, tmp_path):
    out = tmp_path / "out"
    advise(ARM, "--demonstrations", shown, *SMALL, "--for", "cloning", "--out", out)
    page = (out / "report.html").read_text()
    assert "What cloning wants" in page
    assert "What reinforcement learning wants" not in page


@pytest.mark.parametrize(
    ("more", "message"),
    [
        (("--for", "transfer"), "found transfer (nothing is known that ranks gains for it)"),
        (("--for", "reinforcement"), "--train: found no cloning in --for"),
        ((), "--train: found no --task"),
        (("--task", "task.yaml", "--policy-rate", 30), "a divisor of the simulation's 500 Hz"),
        (("--train", 1001), "--train: found 1001; allowed: 0 to 1000"),
    ],
)
def test_trainings_that_cannot_be_are_refused(tmp_path, capsys, more, message):
    out = tmp_path / "out"
    assert message in refused(capsys, "fr3_hand", "--train", 2, *more, "--out", out)
    assert not out.exists()
