"""Where commands are told to write, and what is there already."""

import json
import os
import shutil
from pathlib import Path

import pytest
import yaml
from hypothesis import event, given, settings
from hypothesis import strategies as st

from t2l.cli.main import main
from t2l.outputs import MARK
from tests.fuzz.harness import outcome, snapshot
from tests.fuzz.test_plans import MAPPING, PLAN
from tests.fuzz.test_recordings import QUIET

ROBOT = '<mujoco><worldbody><body><joint name="a"/><joint name="b"/></body></worldbody></mujoco>'
EFFECTS = {"coulomb_friction": {"torque": {"a": 0.1, "b": 0.2}}}
PLACES = [
    "out", "out", "out", "out/deeper", ".", "logs", "logs/table.csv", "logs/table.csv/x", "link",
    "dangling", "x" * 300, "diagnosis", "diagnosis/models", "diagnosis/models/armature.yaml",
    "diagnosis/diagnosis.json", "mapping.yaml", "new.yaml", "../home/logs", "a\nb", "é",
]  # fmt: skip
NAMES = [
    "table.csv", "table.yaml", "table.parquet", "multisine_kp64_kd4.csv", "thesis.tex", "figures",
    "deeper", ".hidden",
]  # fmt: skip
MARKS = [
    '{"command": "t2l import-csv", "entries": ["table.csv", "table.yaml"]}',
    '{"command": "t2l record", "entries": []}',
    '{"command": "t2l explain", "entries": ["steps", "../logs", "thesis.tex/../../logs"]}',
    "", "{", "[]", "3", "null", '{"command": null}', '{"entries": 3, "command": "t2l import-csv"}',
]  # fmt: skip


@pytest.fixture(scope="module")
def root(tmp_path_factory) -> Path:
    root = tmp_path_factory.mktemp("root")
    origin = root / "origin"
    (origin / "logs").mkdir(parents=True)
    rows = [
        ["stamp", "c0", "c1", "p0", "p1"],
        *([f"{20 * i}", "1", "1", "1", "1"] for i in range(20)),
    ]
    (origin / "logs/table.csv").write_text("\n".join(map(",".join, rows)))
    (origin / "logs/thesis.tex").write_text("years of work")
    (origin / "mapping.yaml").write_text(yaml.safe_dump(MAPPING))
    (origin / "plan.yaml").write_text(yaml.safe_dump(PLAN))
    (origin / "robot.xml").write_text(ROBOT)
    models = origin / "diagnosis/models"
    models.mkdir(parents=True)
    for name in ("coulomb_friction", "armature"):
        held = {"robot": "../../robot.xml", "effects": EFFECTS}
        (models / f"{name}.yaml").write_text(yaml.safe_dump(held))
    ranking = [{"effect": "coulomb_friction"}, {"effect": "armature"}]
    (origin / "diagnosis/diagnosis.json").write_text(json.dumps({"ranking": ranking}))
    (origin / "link").symlink_to("logs")
    (origin / "dangling").symlink_to("nowhere")
    return root


@settings(max_examples=80, **QUIET)
@given(data=st.data())
def test_nothing_is_lost_whatever_is_there(root, data):
    home = root / "home"
    shutil.rmtree(home, ignore_errors=True)
    shutil.copytree(root / "origin", home, symlinks=True)
    out = home / "out"
    if data.draw(st.booleans()):
        out.mkdir()
        for name in data.draw(st.lists(st.sampled_from(NAMES), max_size=3, unique=True)):
            kind = data.draw(st.sampled_from(["file", "folder", "link", "hard"]))
            if kind == "file":
                (out / name).write_text("somebody's")
            elif kind == "folder":
                (out / name).mkdir()
                (out / name / "inside").write_text("somebody's")
            elif kind == "link":
                (out / name).symlink_to("../logs/thesis.tex")
            else:
                os.link(home / "logs/table.csv", out / name)
        if data.draw(st.booleans()):
            (out / MARK).write_text(data.draw(st.sampled_from(MARKS)))
    place = data.draw(st.sampled_from(PLACES))
    command = data.draw(
        st.sampled_from(
            [
                ["import-csv", "mapping.yaml", "logs/table.csv"],
                ["import-csv", "mapping.yaml", "logs/table.csv", "--format", "parquet"],
                ["import-csv", "mapping.yaml", "out/table.csv"],
                ["record", "plan.yaml", "--check"],
                ["adopt", "coulomb_friction", "--diagnosis", "diagnosis"],
                ["adopt", "armature", "--diagnosis", "diagnosis"],
            ]
        )
    )
    force = ["--force"] if command[0] != "record" and data.draw(st.booleans()) else []
    before = snapshot(home)
    here = Path.cwd()
    os.chdir(home)
    try:
        message = outcome(lambda: main([*command, "--out", place, *force]))
    finally:
        os.chdir(here)
    event(f"{command[0]} {'ran' if message is None else 'told'}")
    after = snapshot(home)
    # what a command writes under --out, and may replace where it is its own, or by --force
    target = home / place
    entries = {f"table{suffix}" for suffix in (".csv", ".yaml", ".parquet")}
    own = {str(target / name) for name in (*entries, MARK)}
    if command[0] == "adopt":
        own = {str(target)}
    owned = str(out / MARK) in before and place == "out"
    for path, content in before.items():
        if path in own and (force or owned):
            continue
        if force and path.startswith(f"{out}{os.sep}") and place == "out" and owned:
            continue
        assert path in after, f"{path} is gone"
        assert after[path] == content, f"{path} has changed"
    made = {path for path in after if path not in before}
    outside = [path for path in made if not _within(path, target)]
    # the folders that lead to it
    assert all(str(target).startswith(path) for path in outside), outside
    # what a command reads it never writes, whatever is said
    read = {"import-csv": ["logs/table.csv", "mapping.yaml"], "record": ["plan.yaml"]}
    for name in [*read.get(command[0], []), "logs/thesis.tex", "robot.xml"]:
        assert after[str(home / name)] == before[str(home / name)]
    for path in home.joinpath("diagnosis").rglob("*"):
        assert after[str(path)] == before.get(str(path), after[str(path)])


def _within(path: str, target: Path) -> bool:
    real = os.path.realpath(target)
    return path == str(target) or os.path.realpath(path).startswith(real)
