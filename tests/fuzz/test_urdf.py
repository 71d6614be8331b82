"""URDFs that `t2l compare`, `t2l import-csv` and `t2l export` are given."""

import copy
import logging
import shutil
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import pytest
import yaml
from hypothesis import event, given, settings
from hypothesis import strategies as st

from t2l.cli.main import main
from tests.fuzz.generate import damaged
from tests.fuzz.harness import check
from tests.fuzz.test_recordings import METADATA, QUIET, run, table
from tests.robots.test_plant import TWO_JOINTS

SOUND = TWO_JOINTS.replace("shoulder", "hinge").replace("<mimic_/>", "")
NUMBERS = ["nan", "inf", "-inf", "1e400", "-1", "0", "0 0 0", "1e300", "1e-300", "", "1 2", "x"]
NAMES = [
    "",
    " ",
    "hinge",
    "upper",
    "world",
    "../../evil",
    "a/b",
    "é" * 40,
    "n" * 5000,
    "<&>",
    "$(x)",
]
ELEMENTS = [
    '<mimic joint="hinge" multiplier="2"/>',
    '<mimic joint="nowhere"/>',
    "<limit/>",
    '<axis xyz="0 0 0"/>',
    '<origin xyz="nan 0 0"/>',
    '<link name="more"/>',
    '<joint name="more" type="fixed"><parent link="upper"/><child link="base"/></joint>',
    '<inertial><mass value="1"/></inertial>',
    '<mujoco><compiler fusestatic="false" balanceinertia="true"/></mujoco>',
    '<mujoco><compiler meshdir="../.." strippath="false"/></mujoco>',
    '<visual><geometry><mesh filename="package://none/none.stl"/></geometry></visual>',
    '<collision><geometry><box size="1 1 1"/></geometry></collision>',
    '<dynamics damping="-1" friction="-1"/>',
]
TYPES = ["fixed", "continuous", "prismatic", "floating", "planar", "ball", "", "REVOLUTE"]


@pytest.fixture(scope="module")
def home(tmp_path_factory) -> Path:
    home = tmp_path_factory.mktemp("home")
    (home / "bad.csv").write_text("\n".join(map(",".join, table())))
    (home / "bad.yaml").write_text(yaml.safe_dump({**METADATA, "robot": "bad.urdf"}))
    mapping = {k: v for k, v in METADATA.items() if k not in ("notes", "base_position")}
    mapping |= {"robot": "bad.urdf", "columns": {c: c for c in ("time", "q_des.hinge", "q.hinge")}}
    (home / "bad_mapping.yaml").write_text(yaml.safe_dump(mapping))
    (home / "bad_model.yaml").write_text(
        "robot: bad.urdf\neffects: {armature: {inertia: {hinge: 0.01}}}\n"
    )
    return home


@st.composite
def spoilt(draw) -> bytes:
    """A sound URDF with up to three of its elements changed, and now and then its bytes."""
    root = ElementTree.fromstring(SOUND)
    for _ in range(draw(st.integers(0, 3))):
        above, element = draw(
            st.sampled_from([(a, e) for a in root.iter() for e in a] or [(root, root)])
        )
        kind = draw(
            st.sampled_from(["number", "number", "name", "remove", "twice", "add", "type", "swap"])
        )
        key = draw(st.sampled_from(sorted(element.attrib) or [""]))
        if kind == "number" and key:
            element.set(key, draw(st.sampled_from(NUMBERS)))
        elif kind == "name" and key:
            element.set(key, draw(st.sampled_from(NAMES)))
        elif kind == "remove":
            if key and draw(st.booleans()):
                del element.attrib[key]
            elif element in above:
                above.remove(element)
        elif kind == "twice":
            above.append(copy.deepcopy(element))
        elif kind == "add":
            added = ElementTree.fromstring(draw(st.sampled_from(ELEMENTS)))
            draw(st.sampled_from([above, element])).append(added)
        elif kind == "type" and "type" in element.attrib:
            element.set("type", draw(st.sampled_from(TYPES)))
        elif kind == "swap" and {"lower", "upper"} <= set(element.attrib):
            lower, upper = element.get("lower"), element.get("upper")
            element.attrib |= {"lower": upper, "upper": lower}
    content = ElementTree.tostring(root)
    if draw(st.integers(0, 7)) == 0:
        unexpanded = draw(
            st.sampled_from([b'<xacro:include filename="a.xacro"/>', b'<x v="${m}"/>'])
        )
        content = content.replace(b"</robot>", unexpanded + b"</robot>")
    if draw(st.integers(0, 7)) == 0:
        content = damaged(draw, content)
    return content


def looked_at(call, home: Path, names: tuple[str, ...]) -> None:
    logging.disable(logging.WARNING)
    try:
        check(call, home, home / "out", names)
    finally:
        logging.disable(logging.NOTSET)
        shutil.rmtree(home / "out", ignore_errors=True)


NAMED = ("bad", "hinge")


@settings(max_examples=40, **QUIET)
@given(data=st.data())
def test_compare(home, data):
    (home / "bad.urdf").write_bytes(data.draw(spoilt()))
    looked_at(lambda: run(home, "bad.csv"), home, NAMED)


@settings(max_examples=25, **QUIET)
@given(data=st.data())
def test_export(home, data):
    (home / "bad.urdf").write_bytes(data.draw(spoilt()))
    line = ["export", "bad_model.yaml", "--out", "out", "--force"]
    if data.draw(st.booleans()):
        line += ["--kp", "20", "--kd", "0.8", "--control-rate-hz", "500"]
        line += ["--gravity-compensation", data.draw(st.sampled_from(["yes", "no"]))]
        line += data.draw(st.sampled_from([[], ["--joints", "hinge"]]))
    else:
        event("with logs")
        line += ["--logs", "bad.csv"]
    looked_at(lambda: main(line), home, NAMED)


@settings(max_examples=5, **QUIET)
@given(data=st.data())
def test_import(home, data):
    (home / "bad.urdf").write_bytes(data.draw(spoilt()))
    looked_at(
        lambda: main(["import-csv", "bad_mapping.yaml", "bad.csv", "--out", "out"]), home, NAMED
    )


def test_the_sound_one_runs(home):
    (home / "bad.urdf").write_text(SOUND)
    main(["import-csv", str(home / "bad_mapping.yaml"), str(home / "bad.csv"), "--out",
          str(home / "out")])  # fmt: skip
    shutil.rmtree(home / "out")
    run(home, str(home / "bad.csv"))
    main(["export", str(home / "bad_model.yaml"), "--logs", str(home / "bad.csv"), "--out",
          str(home / "out")])  # fmt: skip
    assert (home / "out/model.xml").exists()
    shutil.rmtree(home / "out")
