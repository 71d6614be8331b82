import pytest
from hypothesis import given
from hypothesis import strategies as st

from t2l.errors import OutputError
from t2l.names import MOST_CHARACTERS, heading, is_plain, listed, path_of


@pytest.mark.parametrize("name", ["a", "kp0.5_kd2", "multisine_kp64_kd4", "_x", "x-y", "x.."])
def test_plain_names_lead_into_the_folder(tmp_path, name):
    assert path_of(tmp_path, name, ".csv") == tmp_path / f"{name}.csv"


@pytest.mark.parametrize(
    "name",
    ["", ".", "..", "../../evil", "/etc/passwd", "a/b", "a\\b", "x\n", ".hidden", "-rf", "é", "a b",
     "a\0", "x" * (MOST_CHARACTERS + 1), 3, None],
)  # fmt: skip
def test_no_other_name_becomes_a_path(tmp_path, name):
    assert not is_plain(name)
    with pytest.raises(OutputError, match=r"found the name .*; allowed: letters"):
        path_of(tmp_path, name)


@given(st.text(max_size=8))
def test_a_path_never_leads_out_of_its_folder(name):
    try:
        path = path_of("folder", name, ".csv")
    except OutputError:
        return
    assert path.parent.name == "folder"
    assert path.resolve().parent.name == "folder"


@pytest.mark.parametrize(
    ("name", "written"),
    [
        ("block_stack", "Block Stack"),
        ("block_stack_ur5e", "Block Stack UR5e"),
        ("joint_reach_10_hz", "Joint Reach 10 Hz"),
    ],
)
def test_a_heading_writes_a_name_as_a_person_does(name, written):
    assert heading(name) == written


def test_words_are_listed():
    assert listed(["a", "b", "c"]) == "a, b and c"
    assert listed(["a"]) == "a"
