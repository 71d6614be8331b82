import pytest

from t2l.errors import InputError, RecordingError
from t2l.recordings import read_recording
from tests.recordings.made import written

KEYS = [
    ("robot", "fr4", r"key robot: found 'fr4' \(did you mean fr3\?\); allowed: fr3, .*or the path"),
    ("robot", "arm.xml", r"key robot: found 'arm.xml', but there is no file .*arm.xml"),
    ("robot", None, "key robot: found nothing"),
    ("joints", [], r"key joints: found \[\]"),
    ("joints", ["a", "a"], r"key joints: found \['a', 'a'\]; allowed: .*different"),
    ("joints", "a", "key joints: found 'a'; allowed: a list"),
    ("kp", -1, "key kp: found -1; allowed: one number from 0 up"),
    ("kp", -3, "key kp: found -3"),
    ("kp", "stiff", "key kp: found 'stiff'"),
    ("kp", True, "key kp: found True"),
    ("kp", float("nan"), "key kp: found nan"),
    ("kp", [1, 2, 3], "key kp: found 3 numbers; allowed: one number from 0 up, or 2, one"),
    ("kp", [1, -1], r"key kp: found \[1, -1\]"),
    ("kd", -1, "key kd: found -1; allowed: one number from 0 up"),
    ("kd", float("inf"), "key kd: found inf"),
    ("command_rate_hz", 0, "key command_rate_hz: found 0; allowed: a number above 0"),
    ("control_rate_hz", -5, "key control_rate_hz: found -5"),
    ("control_rate_hz", "1k", "key control_rate_hz: found '1k'"),
    ("gravity_compensation", "maybe", "key gravity_compensation: found 'maybe'; allowed: true or"),
    ("gravity_compensation", 1, "key gravity_compensation: found 1"),
    ("base_position", [0, 0], r"key base_position: found \[0, 0\]; allowed: three numbers"),
    ("notes", 3, "key notes: found 3; allowed: text"),
    ("stiffness", 3, "key stiffness: found an unknown key; allowed: robot, joints"),
    (
        "controlrate_hz",
        3,
        r"key controlrate_hz: found an unknown key \(did you mean control_rate_hz\?\)",
    ),
]


@pytest.mark.parametrize(("key", "value", "message"), KEYS)
def test_a_wrong_key_is_named(tmp_path, key, value, message):
    files = written(tmp_path)
    files.spoil_key(key, value)
    with pytest.raises(RecordingError, match=f"swing.yaml: {message}"):
        read_recording(files.table)


@pytest.mark.parametrize("key", ["robot", "joints", "kp", "gravity_compensation"])
def test_a_missing_key_is_named(tmp_path, key):
    files = written(tmp_path)
    del files.keys[key]
    files.save()
    with pytest.raises(RecordingError, match=f"swing.yaml: key {key}: found nothing; allowed: "):
        read_recording(files.table)


@pytest.mark.parametrize(
    ("text", "message"), [("a: [", "what is not YAML"), ("- 3", r"found \[3\]; allowed: the keys")]
)
def test_a_foreign_yaml_is_named(tmp_path, text, message):
    files = written(tmp_path)
    files.yaml.write_text(text)
    with pytest.raises(InputError, match=message):
        read_recording(files.table)


def test_empty_optional_keys_are_as_good_as_none(tmp_path):
    files = written(tmp_path)
    files.keys |= {"notes": "", "base_position": None}
    files.save()
    assert read_recording(files.table).notes == ""
