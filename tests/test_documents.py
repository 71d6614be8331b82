import json
import math
import os
import time

import pytest
import yaml
from hypothesis import assume, given
from hypothesis import strategies as st

from snakemake_logger_plugin_t2l import configfiles
from t2l.documents import MOST_BYTES, MOST_LEVELS, MOST_NODES, read_json, read_yaml, to_yaml
from t2l.errors import InputError

BOMB = "\n".join(
    ["a0: &a0 [x, x]", *(f"a{i}: &a{i} [{', '.join([f'*a{i - 1}'] * 9)}]" for i in range(1, 20))]
)


@pytest.fixture
def path(tmp_path):
    return tmp_path / "file.yaml"


def test_what_people_write_is_read_at_its_word(path):
    path.write_text(
        "study: x\ngains: &g {kp: 1e-5, kd: 1.0e-5, seed: 1.0}\nagain: *g\nday: 2026-11-22\n"
        "merged: {<<: *g, kd: 2}\nnothing:\n"
    )
    assert read_yaml(path, "a file") == {
        "study": "x",
        "gains": {"kp": 1e-5, "kd": 1e-5, "seed": 1.0},
        "again": {"kp": 1e-5, "kd": 1e-5, "seed": 1.0},
        "day": "2026-11-22",
        "merged": {"kp": 1e-5, "kd": 2, "seed": 1.0},
        "nothing": None,
    }


@pytest.mark.parametrize(
    "text",
    # YAML 1.1 has 90, 5400.5, 8, 5, 1000, true and false for them, and an error for =
    ["1:30", "1:30:00.5", "010", "-07", "0b101", "1_000", "1_0.5", "yes", "No", "on", "OFF", "y",
     "0o17", "=", "1.2.3", ".", "+", "e5", "0x", "2026-11-22"],
)  # fmt: skip
def test_what_only_yaml_1_1_takes_for_a_number_or_a_switch_is_text(path, text):
    path.write_text(f"a: {text}\n{text}: b\n")
    assert read_yaml(path, "a file") == {"a": text, text: "b"}


@pytest.mark.parametrize(
    ("text", "number"),
    [("10", 10), ("-3", -3), ("0", 0), ("0x1F", 31), ("1.5", 1.5), (".5", 0.5), ("2.", 2.0),
     ("1e5", 1e5), ("1.5e3", 1500.0), ("-1.5E-3", -0.0015), ("+.inf", math.inf), ("true", True),
     ("False", False), ("~", None)],
)  # fmt: skip
def test_what_everybody_takes_for_a_number_is_one(path, text, number):
    path.write_text(f"a: {text}\n")
    found = read_yaml(path, "a file")["a"]
    assert (found, type(found)) == (number, type(number))


def test_a_configuration_of_snakemake_is_read_alike(path):
    path.write_text("damping: 1:30\nseed: 010\n")
    assert configfiles.load(path) == {"damping": "1:30", "seed": "010"}


@given(st.text("0123456789.:_-+exobnyfNYO~=<", max_size=6) | st.text(max_size=5))
def test_text_that_is_written_is_read_as_that_text(tmp_path_factory, text):
    assume(yaml.safe_load(json.dumps(text)) == text and "\0" not in text)  # none that YAML forbids
    path = tmp_path_factory.getbasetemp() / "written"
    path.write_text(to_yaml({"a": text}, allow_unicode=True), encoding="utf-8")
    assert read_yaml(path, "a file") == {"a": text} == yaml.safe_load(path.read_bytes())


@pytest.mark.parametrize(("read", "name"), [(read_yaml, "a.yaml"), (read_json, "a.json")])
def test_what_is_no_regular_file_is_not_waited_for(tmp_path, read, name):
    os.mkfifo(tmp_path / name)
    said = rf"{name}: the file: found a named pipe \(FIFO\); allowed: a regular file"
    with pytest.raises(InputError, match=said):
        read(tmp_path / name, "a file")
    for device in ("/dev/zero", "/dev/null"):
        with pytest.raises(InputError, match=f"{device}: the file: found a device"):
            read(device, "a file")


@pytest.mark.parametrize(
    ("read", "text"), [(read_yaml, '{a: ["\\0"]}'), (read_json, '{"\\u0000": 1}')]
)
def test_no_text_has_a_null_character(path, read, text):
    path.write_text(text)
    with pytest.raises(InputError, match="found a null character in a text"):
        read(path, "a file")


@pytest.mark.parametrize(
    ("content", "said"),
    [
        ("kp: 1\nkd: 2\nkp: 3", "the key 'kp' twice, line 3"),
        ("a: {b: {kp: 1, kp: 2}}", "the key 'kp' twice"),
        ("1: a\n1: b", "the key '1' twice"),
        (BOMB, f"line .*more values, aliases written out; allowed: at most {MOST_NODES}"),
        ("a: &a {b: *a}", r"line 1: found \*a within itself"),
        ("&a [*a]", r"\*a within itself"),
        ("a: *nowhere", "undefined alias, line 1"),
        ("[" * 100_000, f"deeper nesting; allowed: at most {MOST_LEVELS} levels"),
        ("{a: " * 2000, "deeper nesting"),
        ("- " * 5000, "deeper nesting"),
        ("a: " + "9" * 5000, "what is not YAML"),
        ("? [1, 2]\n: 3", "what is not YAML"),
        ("a: 1\n--- \nb: 2", "what is not YAML"),
        ("!!python/object/apply:os.system [exit]", "what is not YAML"),
        ("a: [", "what is not YAML"),
        ("x" * (MOST_BYTES + 1), f"more than {MOST_BYTES} bytes"),
        (b"caf\xe9: 1", r"what is not text in UTF-8 \(byte 3\)"),
        ("a: 1".encode("utf-16"), "what is not text in UTF-8"),
        (b"\x00\x01\x02", "what is not YAML"),
    ],
    ids=lambda value: str(value)[:20],
)
def test_what_nobody_means_is_told_with_its_file(path, content, said):
    path.write_bytes(content.encode() if isinstance(content, str) else content)
    started = time.monotonic()
    with pytest.raises(InputError, match=f"file.yaml: .*{said}"):
        read_yaml(path, "a file")
    # the bomb stands for 10^19 values
    assert time.monotonic() - started < 10


@pytest.mark.parametrize("name", ["nowhere.yaml", ".", "file.yaml/x"])
def test_a_file_that_is_not_there_says_what_it_is_for(tmp_path, name):
    (tmp_path / "file.yaml").touch()
    with pytest.raises(InputError, match="found nothing; allowed: a plan, which"):
        read_yaml(tmp_path / name, "a plan, which says what to record")


@pytest.mark.parametrize(
    ("content", "said"),
    [
        ('{"a": 1, "a": 2}', "the key 'a' twice"),
        ("[" * 100_000, "what is not JSON"),
        ('{"a": ' + "9" * 5000 + "}", "what is not JSON"),
        ("", "what is not JSON"),
        (b"\xff", "what is not text in UTF-8"),
    ],
    ids=lambda value: str(value)[:20],
)
def test_json_likewise(path, content, said):
    path.write_bytes(content.encode() if isinstance(content, str) else content)
    with pytest.raises(InputError, match=said):
        read_json(path, "a file")


@given(
    content=st.one_of(st.binary(max_size=200), st.text("{}[]:,-&*? \n'\"ab1<!|>%@#", max_size=60))
)
def test_any_content_is_read_or_told(tmp_path_factory, content):
    path = tmp_path_factory.getbasetemp() / "any"
    path.write_bytes(content.encode() if isinstance(content, str) else content)
    for read in (read_yaml, read_json):
        try:
            read(path, "a file")
        except InputError as error:
            assert str(path) in str(error)  # noqa: PT017
