"""The worked example of docs/servo_registers.md: its arithmetic, and the recording that results."""

import doctest
import re
from pathlib import Path

import numpy as np
import pytest
import yaml

from t2l.effects.registry import builtin
from t2l.recordings.metadata import check_metadata
from tests.conftest import ROOT

PAGE = ROOT / "docs/servo_registers.md"


def test_the_arithmetic_is_right():
    found = doctest.testfile(str(PAGE), module_relative=False, encoding="utf-8")
    assert found.attempted >= 10
    assert found.failed == 0


def test_the_table_holds_what_the_formula_gives():
    rows = re.findall(
        r"^\| (.*V), .*\| ([\d.]+) N·m \| ([\d.]+) N·m/rad \|$", PAGE.read_text(), re.M
    )
    assert len(rows) == 4
    for _, stall, kp in rows:
        assert float(kp) == pytest.approx(0.166 * 16 * float(stall), rel=0.03)


def test_the_recording_is_one(tmp_path):
    text = re.search(r"```yaml\n(.*?)```", PAGE.read_text(), re.S)[1]
    (tmp_path / "so101.xml").write_text("<mujoco/>")
    found = check_metadata(yaml.safe_load(text), Path(tmp_path / "one.yaml"))
    assert len(found["joints"]) == 6
    np.testing.assert_allclose(found["kp"], 8.9)


def test_the_bounds_of_the_factor_are_those_of_the_effect():
    bounds = {p.name: (p.lower, p.upper) for p in builtin()["controller_gains"].parameters}
    assert bounds == {"kp_factor": (0.1, 10.0), "kd_factor": (0.05, 20.0)}
