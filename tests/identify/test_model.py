import numpy as np
import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st

from t2l.effects.registry import builtin
from t2l.errors import ConfigurationError
from t2l.identify.model import Model, check_joints, from_vector, read_model, write_model
from tests.diagnose.made import pendulum

JOINTS = ("shoulder", "elbow", "wrist")
HAS = {"dof_armature": 5.0, "dof_damping": 30.0, "dof_frictionloss": 30.0}


def value(parameter):
    low, high = bounds(parameter)
    if parameter.log:
        logs = st.floats(*np.log([low, high]))
        return logs.map(lambda u: float(np.clip(np.exp(u), low, high)))
    return st.floats(low, high)


def bounds(parameter):
    """What is possible for a robot of any size, of `HAS` no more than it has."""
    possible = parameter.in_units()
    low = max(possible.lower, -HAS[parameter.adds_to] if parameter.adds_to else -1e6)
    return low or 1e-6 * parameter.log, min(possible.upper, 1e6)


def arm(folder):
    """A robot of these joints, of which an effect may take away as much as its bounds allow."""
    has = " ".join(f'{name.removeprefix("dof_")}="{value}"' for name, value in HAS.items())
    bodies = "".join(
        f'<body><joint name="{name}" {has}/><geom size="0.1"/></body>' for name in JOINTS
    )
    path = folder / "arm.xml"
    if not path.exists():
        path.write_text(f"<mujoco><worldbody>{bodies}</worldbody></mujoco>")
    return str(path)


@st.composite
def adopted(draw, joints=JOINTS):
    """Effects with values anywhere within their bounds, on some of the joints."""
    effects = {}
    for name in draw(st.lists(st.sampled_from(sorted(builtin())), unique=True, max_size=4)):
        on = sorted(draw(st.sets(st.sampled_from(joints), min_size=1)))
        effects[name] = {
            p.name: {joint: draw(value(p)) for joint in on} if p.per_joint else draw(value(p))
            for p in builtin()[name].parameters
        }
    return effects


def numbers(effects):
    """Every value, with where it stands."""
    for name, values in effects.items():
        for parameter, found in values.items():
            each = found.items() if isinstance(found, dict) else [(None, found)]
            yield from (((name, parameter, joint), number) for joint, number in each)


def assert_alike(first, second):
    first, second = dict(numbers(first)), dict(numbers(second))
    assert first.keys() == second.keys()
    for where, number in first.items():
        assert second[where] == pytest.approx(number, rel=1e-5, abs=1e-12), where


@settings(deadline=None, max_examples=60)
@given(adopted())
def test_a_model_reads_as_it_was_written(tmp_path_factory, effects):
    folder = tmp_path_factory.getbasetemp() / "round_trip"
    path = folder / "models" / "model.yaml"
    write_model(Model("fr3", effects), path, "two lines\nof comment")
    again = read_model(path)
    assert again.robot == "fr3"
    assert_alike(effects, again.effects)


@settings(deadline=None, max_examples=30)
@given(adopted())
def test_a_model_survives_the_way_to_a_vector_and_back(tmp_path_factory, effects):
    model = Model(arm(tmp_path_factory.getbasetemp()), effects)
    layout, u = model.vector(JOINTS)
    again = from_vector(model, layout, u, JOINTS)
    assert_alike(effects, again.effects)


@pytest.mark.parametrize("number", [1e-05, 2e-07, 0.00012, 20.0])
def test_numbers_that_yaml_would_read_as_text_are_written_as_numbers(tmp_path, number):
    model = Model("fr3", {"torque_offset": {"torque": {"elbow": number}}})
    write_model(model, tmp_path / "model.yaml")
    assert read_model(tmp_path / "model.yaml").effects == model.effects


@pytest.mark.parametrize("joint", ["1", "on", "null", "base: yaw", "a,b", "link/joint#2", "关节"])
def test_joints_may_have_any_name(tmp_path, joint):
    model = Model("fr3", {"torque_offset": {"torque": {joint: 0.5}}})
    write_model(model, tmp_path / "model.yaml")
    assert read_model(tmp_path / "model.yaml").effects == model.effects


@pytest.mark.parametrize("folder", ["plain", "with space", "lab #2", "a: b"])
def test_a_robots_path_is_kept_relative_to_the_file(tmp_path, folder):
    """All that belongs together may move."""
    here, there = tmp_path / "here", tmp_path / "there"
    (here / folder).mkdir(parents=True)
    write_model(Model(pendulum(here / folder)), here / "models" / "model.yaml")
    here.rename(there)
    again = read_model(there / "models" / "model.yaml")
    assert again.robot == str(there / folder / "pendulum.xml")


def test_a_person_can_write_one(tmp_path):
    path = tmp_path / "model.yaml"
    path.write_text(
        f"robot: {arm(tmp_path)}\neffects:\n  coulomb_friction:\n    torque: {{elbow: 1}}\n"
        "  command_delay:\n    delay: 0.012  # s\n"
    )
    model = read_model(path)
    layout, u = model.vector(JOINTS)
    assert {slot.parameter.name: slot.joint for slot in layout.slots} == {
        "torque": 1,
        "delay": None,
    }
    assert sorted(u) == pytest.approx([0.012, 1.0])
    path.write_text("robot: fr3\n")
    assert read_model(path).effects == {}


FRICTION = {"robot": "fr3", "effects": {"coulomb_friction": {"torque": {"elbow": 0.5}}}}
COGGING = {"amplitude": {"elbow": 0.1}, "phase": {"elbow": 0.1}, "periods": {"elbow": 9.0}}


def with_effect(name, values):
    return {"robot": "fr3", "effects": {name: values}}


@pytest.mark.parametrize(
    ("content", "key"),
    [
        ([], "robot"),
        ({}, "robot"),
        ({"robot": None}, "robot"),
        ({"robot": "arm.xml"}, "robot"),
        ({**FRICTION, "effect": {}}, "effect"),
        ({"robot": "fr3", "effects": ["armature"]}, "effects"),
        ({"robot": "fr3", "effects": {"rubber": {}}}, "rubber"),
        ({"robot": "fr3", "effect_files": 3}, "effect_files"),
        ({"robot": "fr3", "effect_files": "mine.py"}, "effect_files"),
        (with_effect("coulomb_friction", None), "coulomb_friction"),
        (with_effect("coulomb_friction", {}), "coulomb_friction"),
        (with_effect("coulomb_friction", {"level": {"elbow": 1}}), "coulomb_friction"),
        (with_effect("coulomb_friction", {"torque": 0.5}), "coulomb_friction.torque"),
        (with_effect("coulomb_friction", {"torque": {}}), "coulomb_friction.torque"),
        (with_effect("coulomb_friction", {"torque": {"elbow": "x"}}), "coulomb_friction.torque"),
        (with_effect("coulomb_friction", {"torque": {"elbow": True}}), "coulomb_friction.torque"),
        (with_effect("torque_constant", {"factor": {"elbow": 99.0}}), "torque_constant.factor"),
        (with_effect("torque_dead_zone", {"zone": {"elbow": -1.0}}), "torque_dead_zone.zone"),
        (with_effect("torque_saturation", {"limit": {"elbow": 0.0}}), "torque_saturation.limit"),
        (
            with_effect("coulomb_friction", {"torque": {"elbow": float("nan")}}),
            "coulomb_friction.torque",
        ),
        (with_effect("command_delay", {"delay": {"elbow": 0.1}}), "command_delay.delay"),
        (with_effect("command_delay", {"delay": -0.1}), "command_delay.delay"),
        (with_effect("coulomb_friction", {1: 2, "torque": {"elbow": 0.5}}), "coulomb_friction"),
        (with_effect("cogging", COGGING | {"phase": {"wrist": 0.1}}), "cogging.phase"),
    ],
)
def test_what_is_wrong_is_named_with_file_and_key(tmp_path, content, key):
    path = tmp_path / "model.yaml"
    path.write_text(yaml.safe_dump(content))
    with pytest.raises(ConfigurationError) as caught:
        read_model(path)
    assert str(path) in str(caught.value)
    assert key in str(caught.value)


@pytest.mark.parametrize("content", [b"robot: [", b"\xff\xfe", b"a: b: c"])
def test_a_file_that_is_not_yaml_is_named(tmp_path, content):
    (tmp_path / "model.yaml").write_bytes(content)
    with pytest.raises(ConfigurationError, match=r"model\.yaml: the file: found what is not"):
        read_model(tmp_path / "model.yaml")


def test_a_missing_effect_file_is_named(tmp_path):
    (tmp_path / "model.yaml").write_text("robot: fr3\neffect_files: [mine.py]\n")
    with pytest.raises(ConfigurationError, match=f"{tmp_path}/mine.py: no such file"):
        read_model(tmp_path / "model.yaml")


def test_a_missing_file_is_named(tmp_path):
    with pytest.raises(ConfigurationError, match=r"nowhere\.yaml: the file: found nothing"):
        read_model(tmp_path / "nowhere.yaml")


def test_a_folder_in_place_of_the_file_is_named(tmp_path):
    with pytest.raises(ConfigurationError, match=str(tmp_path)):
        read_model(tmp_path)


def test_joints_that_no_recording_has_are_named():
    model = Model("fr3", {"torque_offset": {"torque": {"elbow": 0.1, "gripper": 0.1}}})
    check_joints("m.yaml", Model("fr3", {"command_delay": {"delay": 0.1}}), JOINTS)
    with pytest.raises(ConfigurationError, match=r"m\.yaml.*torque_offset\.torque.*'gripper'"):
        check_joints("m.yaml", model, JOINTS)


def coupling(folder, **changes):
    """A model file of a cable from the wrist, and its path."""
    values = {"stiffness": 2.0, "damping": 0.0, "ratio": -0.5, "rest": 0.1, **changes}
    written = {name: {"wrist": value} for name, value in values.items()}
    path = folder / "model.yaml"
    path.write_text(yaml.safe_dump({"robot": arm(folder), "effects": {"joint_coupling": written}}))
    return read_model(path), path


def test_a_cable_runs_to_the_joint_before_where_a_file_does_not_say(tmp_path):
    model, _ = coupling(tmp_path)
    assert model.effects["joint_coupling"]["before"] == {"wrist": 1.0}
    assert model.effects == coupling(tmp_path, before=1.0)[0].effects


@pytest.mark.parametrize("before", [3.0, 1.5])
def test_a_cable_to_no_joint_is_named(tmp_path, before):
    model, path = coupling(tmp_path, before=before)
    with pytest.raises(ConfigurationError, match=rf"before = {before:g} of wrist; allowed: .* 2,"):
        check_joints(path, model, JOINTS)
