import json
import os
import shutil

import numpy as np
import pytest
from benchmarks.hidden_effects.generator import record, write

from t2l.registry import TRUST
from tests.conftest import ROOT

EFFECT = """
from t2l.effects.viscous_friction import ViscousFriction


class Mine(ViscousFriction):
    name = "mine"
"""
PENDULUM = ROOT / "benchmarks/hidden_effects/robots/pendulum.xml"


@pytest.fixture
def clean_project(empty_project, monkeypatch):
    """Three recordings of a pendulum that hides nothing."""
    monkeypatch.setenv(TRUST, "1")
    folder = empty_project.folder
    shutil.copy(PENDULUM, folder / "pendulum.xml")
    for kp, kd in ((5.0, 0.3), (20.0, 0.8), (80.0, 2.0)):
        frame = record(
            PENDULUM, ("hinge",), kp, kd,
            lambda t: 0.3 + 0.4 * np.sin(2 * np.pi * 0.8 * np.asarray(t))[:, None],
            duration_s=1.5, encoder_noise_rad=1e-4, sample_rate_hz=200,
            rng=np.random.default_rng(int(kp)),
        )  # fmt: skip
        write(
            frame, folder / "logs" / f"kp{kp:g}", robot=folder / "pendulum.xml",
            joints=("hinge",), kp=kp, kd=kd, command_rate_hz=50, control_rate_hz=1000,
            gravity_compensation=False,
        )  # fmt: skip
    (folder / "effects").mkdir()
    (folder / "effects/mine.py").write_text(EFFECT)
    empty_project.config["diagnosis"] = {"recordings": ["logs"], "effects": ["effects"]}
    return empty_project


def test_the_diagnosis_target_explains_and_is_cached(clean_project, monkeypatch):
    done = clean_project.run("--", "diagnosis")
    assert done.returncode == 0, done.stdout[-4000:]
    folder = clean_project.results / "diagnosis"
    found = json.loads((folder / "explanation.json").read_text())
    assert found["verdict"] == "no_missing_effect"
    assert found["steps"][0]["effects"] == []
    assert found["steps"][-1]["test_rmse_q_rad"] < 1.1 * found["noise_floor_rad"]
    for name in ("report.html", "model.yaml", "before/comparison.json", "figures/overlays.png"):
        assert (folder / name).stat().st_size > 0
    assert not {"explain", "diagnosis_report"} & set(clean_project.planned("all"))
    done = clean_project.run("--report", "report.html", "--", "diagnosis")
    assert done.returncode == 0, done.stdout[-3000:]
    page = (clean_project.folder / "report.html").read_text()
    for name in ("error_falling", "overlays", "error_by_cell", "residual_by_condition", "spectrum"):
        assert f"{name}.png" in page
    assert "Amplitude density of the error" in page

    stages = {"compare_before", "explain", "compare_after", "diagnosis_report"}
    # one of the files that `t2l.config.watched` names
    path = clean_project.folder / "effects/mine.py"
    content = path.read_text()
    path.write_text(content + "\n")
    assert stages <= set(clean_project.planned("diagnosis"))
    path.write_text(content)
    os.utime(path, times=(0, 0))
    assert clean_project.planned("diagnosis") == {}

    # a newer t2l than the one that is installed
    newer = clean_project.folder / "newer"
    (newer / "t2l-1000.0.dist-info").mkdir(parents=True)
    (newer / "t2l-1000.0.dist-info/METADATA").write_text(
        "Metadata-Version: 2.1\nName: t2l\nVersion: 1000.0\n"
    )
    paths = [str(newer), *filter(None, [os.environ.get("PYTHONPATH")])]
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join(paths))
    assert stages <= set(clean_project.planned("diagnosis"))


def test_a_bad_recording_is_named(clean_project):
    table = clean_project.folder / "logs" / "kp20.csv"
    table.write_text(table.read_text().replace("time", "tome", 1))
    done = clean_project.run("--", "diagnosis")
    assert done.returncode != 0
    assert "kp20.csv" in done.stdout
    assert "time" in done.stdout
