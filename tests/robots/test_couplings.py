import re

import pytest

from t2l.robots.couplings import couplings
from tests.robots.test_plant import TWO_JOINTS

COUPLED = """<mujoco><worldbody>
  <body name="one"><joint name="a" axis="0 1 0"/><geom size="0.1"/>
    <body name="two"><joint name="b" axis="0 1 0"/><geom size="0.1"/></body></body>
  <body name="three" pos="1 0 0"><joint name="c" axis="0 1 0"/><geom size="0.1"/>
    <body name="four"><joint name="d" axis="0 1 0"/><geom size="0.1"/></body></body>
</worldbody><equality>{}</equality></mujoco>"""


@pytest.mark.parametrize(
    ("equality", "joints", "said"),
    [
        (
            '<joint joint1="b" joint2="a"/>',
            "a",
            ["b is held still: .*joint b follows a, which is left"],
        ),
        ('<joint joint1="b" joint2="a"/>', "ab", ["each moves alone: .*joint b follows a"]),
        ('<joint joint1="b" joint2="a"/>', "c", []),
        (
            '<connect body1="two" body2="four" anchor="0 0 0"/>',
            "a",
            ["^a moves freely.*two and four are joined"],
        ),
        ('<connect body1="three" body2="four" anchor="0 0 0"/>', "c", []),
        ('<weld body1="four"/>', "d", ["four and the world are joined"]),
    ],
)
def test_a_coupling_that_is_left_out_is_told(tmp_path, equality, joints, said):
    """Of the joints that move; what holds two others together changes nothing."""
    path = tmp_path / "coupled.xml"
    path.write_text(COUPLED.format(equality))
    found = couplings(str(path), tuple(joints))
    assert len(found) == len(said)
    for sentence, pattern in zip(found, said, strict=True):
        assert re.search(pattern, sentence)


def test_a_mimic_of_a_urdf_is_told(tmp_path):
    path = tmp_path / "arm.urdf"
    path.write_text(TWO_JOINTS.replace("<mimic_/>", '<mimic joint="shoulder" multiplier="-1"/>'))
    (found,) = couplings(str(path), ("shoulder",))
    assert "joint elbow follows shoulder" in found
    assert "elbow is held still" in found
