"""Recordings, models and effects that `t2l compare` is given."""

import shutil
from pathlib import Path

import numpy as np
import pytest
import yaml
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from t2l.cli.main import main
from t2l.diagnose.compare import compare
from t2l.diagnose.recordings_and_model import read_recordings_and_model
from t2l.identify.model import ModelFile
from t2l.recordings.metadata import Metadata
from tests.diagnose.made import pendulum
from tests.fuzz.generate import as_bytes, damaged, spoilt
from tests.fuzz.harness import check

QUIET = {"deadline": None, "suppress_health_check": list(HealthCheck)}

METADATA = {
    "robot": "pendulum.xml",
    "joints": ["hinge"],
    "kp": 20,
    "kd": [0.8],
    "command_rate_hz": 50,
    "control_rate_hz": 500,
    "gravity_compensation": False,
    "base_position": [0, 0, 0.1],
    "notes": "made up",
}
MODEL = {
    "robot": "pendulum.xml",
    "effects": {
        "coulomb_friction": {"torque": {"hinge": 0.05}},
        "command_delay": {"delay": 0.004},
    },
    "effect_files": [],
}
TIME = np.arange(16) / 50
# figures and page take a hundred times as long as the comparison
WHOLE = st.sampled_from([False] * 30 + [True])
CELLS = ["", "nan", "x", "1e400", "-inf", "1_0", "0x10", " 3 ", "1e9", "9" * 400, '"', "\0", "é"]


def table() -> list[list[str]]:
    """Rows of a CSV that is sound."""
    rows = [["time", "q_des.hinge", "q.hinge", "dq.hinge"]]
    rows += [[f"{t:.3f}", f"{np.sin(3 * t):.4f}", f"{np.sin(3 * t - 0.1):.4f}", ""] for t in TIME]
    return rows


@pytest.fixture(scope="module")
def home(tmp_path_factory) -> Path:
    home = tmp_path_factory.mktemp("home")
    pendulum(home)
    (home / "sound.yaml").write_text(yaml.safe_dump(METADATA))
    (home / "sound.csv").write_text("\n".join(map(",".join, table())))
    return home


def run(home: Path, *arguments: str, whole: bool = False) -> None:
    """`t2l compare`, its figures and page only now and then."""
    if whole:
        main(["compare", *arguments, "--out", "out"])
        return
    model = Path(arguments[2]) if len(arguments) > 2 else None
    found, recordings, _ = read_recordings_and_model([Path(arguments[0])], (), model)
    compare(found, recordings)


def clean(home: Path) -> None:
    shutil.rmtree(home / "out", ignore_errors=True)


@settings(max_examples=150, **QUIET)
@given(data=st.data())
def test_metadata(home, data):
    document = data.draw(spoilt(METADATA, Metadata))
    (home / "bad.csv").write_text("\n".join(map(",".join, table())))
    (home / "bad.yaml").write_bytes(data.draw(as_bytes(document)))
    whole = data.draw(WHOLE)
    names = ("bad", "pendulum.xml")
    check(lambda: run(home, "bad.csv", whole=whole), home, home / "out", names)
    clean(home)


@settings(max_examples=100, **QUIET)
@given(data=st.data())
def test_tables(home, data):
    rows = table()
    for _ in range(data.draw(st.integers(0, 3))):
        kind = data.draw(st.sampled_from(["cell", "head", "row", "drop", "times", "scale"]))
        at = data.draw(st.integers(0, len(rows) - 1))
        if kind == "cell" and rows[at]:
            rows[at][data.draw(st.integers(0, len(rows[at]) - 1))] = data.draw(
                st.sampled_from(CELLS)
            )
        elif kind == "head" and rows[0]:
            name = data.draw(
                st.sampled_from(["time", "q.hinge", "tau.hinge", "q.x", "", "$\\frac{$"])
            )
            rows[0][data.draw(st.integers(0, len(rows[0]) - 1))] = name
        elif kind == "row":
            rows.insert(at, data.draw(st.lists(st.sampled_from(CELLS), max_size=6)))
        elif kind == "drop" and len(rows) > 1:
            del rows[at]
        elif kind in ("times", "scale"):
            factor = data.draw(st.sampled_from([1e3, 1e6, 1e9, -1, 0, 1e-6, 57.3, 1e300]))
            column = 0 if kind == "times" else 1
            for row in rows[1:]:
                try:
                    row[column] = str(float(row[column]) * factor)
                except (ValueError, IndexError):
                    continue
    content = "\n".join(map(",".join, rows)).encode()
    if data.draw(st.integers(0, 5)) == 0:
        content = damaged(data.draw, content)
    if data.draw(st.integers(0, 9)) == 0:
        content = content[: data.draw(st.integers(0, len(content)))]
    (home / "bad.csv").write_bytes(content)
    (home / "bad.yaml").write_text(yaml.safe_dump(METADATA))
    whole = data.draw(WHOLE)
    check(lambda: run(home, "bad.csv", whole=whole), home, home / "out", ("bad",))
    clean(home)


@settings(max_examples=80, **QUIET)
@given(data=st.data())
def test_models(home, data):
    document = data.draw(spoilt(MODEL, ModelFile))
    (home / "bad.yaml").unlink(missing_ok=True)
    (home / "bad.csv").unlink(missing_ok=True)
    (home / "bad_model.yaml").write_bytes(data.draw(as_bytes(document)))
    check(
        lambda: run(home, "sound.csv", "--model", "bad_model.yaml"),
        home, home / "out", ("bad_model", "sound.csv"),
    )  # fmt: skip
    clean(home)


MJCF = (
    '<mujoco><compiler angle="radian"/><worldbody><body pos="0 0 1"><joint name="hinge" '
    'axis="0 1 0" armature="0.005" damping="0.02" range="-9 9"/><inertial pos="0 0 -0.25" '
    'mass="0.5" diaginertia="1e-4 1e-4 1e-4"/></body></worldbody></mujoco>'
)
REPLACED = [
    ('mass="0.5"', 'mass="0"'),
    ('mass="0.5"', 'mass="-1"'),
    ('mass="0.5"', 'mass="1e300"'),
    ("<inertial", "<geom type='mesh' mesh='none'/><inertial"),
    ('range="-9 9"', 'range="9 -9"'),
    ('axis="0 1 0"', 'axis="0 0 0"'),
    ('name="hinge"', 'name="other"'),
    ('"1e-4 1e-4 1e-4"', '"1 9 1"'),
    ('armature="0.005"', 'armature="nan"'),
    ('armature="0.005"', 'armature="-1"'),
    ("<worldbody>", "<include file='none.xml'/><worldbody>"),
    ("</mujoco>", ""),
    ("<worldbody>", "<asset><mesh name='m' file='none.obj'/></asset><worldbody>"),
    ('damping="0.02"', 'damping="1e300"'),
    ('<joint name="hinge"', '<freejoint name="f"/><joint name="hinge"'),
    ('<joint name="hinge" axis="0 1 0"', '<joint name="hinge" type="ball"'),
    ('diaginertia="1e-4 1e-4 1e-4"', ""),
    ("<mujoco>", "<robot>"),
    ("pos=", "pox="),
]


@settings(max_examples=60, **QUIET)
@given(data=st.data())
def test_robots(home, data):
    text = MJCF
    for old, new in data.draw(st.lists(st.sampled_from(REPLACED), max_size=3)):
        text = text.replace(old, new)
    content = damaged(data.draw, text.encode()) if data.draw(st.booleans()) else text.encode()
    (home / "bad_robot.xml").write_bytes(content)
    (home / "bad.yaml").write_text(yaml.safe_dump({**METADATA, "robot": "bad_robot.xml"}))
    (home / "bad.csv").write_text("\n".join(map(",".join, table())))
    check(lambda: run(home, "bad.csv"), home, home / "out", ("bad",))
    clean(home)
