import time

import pytest
from hypothesis import given
from hypothesis import strategies as st

from t2l.documents import MOST_BYTES, MOST_LEVELS, MOST_NODES, read_json, read_yaml
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
        "merged: {<<: *g, kd: 2}\nwords: yes\nnothing:\n"
    )
    assert read_yaml(path, "a file") == {
        "study": "x",
        "gains": {"kp": 1e-5, "kd": 1e-5, "seed": 1.0},
        "again": {"kp": 1e-5, "kd": 1e-5, "seed": 1.0},
        "day": "2026-11-22",
        "merged": {"kp": 1e-5, "kd": 2, "seed": 1.0},
        "words": True,
        "nothing": None,
    }


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
