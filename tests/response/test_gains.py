import json
import os
from dataclasses import replace
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from t2l.cli.main import main
from t2l.errors import RecordingError
from t2l.recordings import Recording, write_recording
from t2l.response.joints import responses
from t2l.response.motions import read_motions
from tests.response.made import rows

# a folder of real recordings of one robot under many gains, for those who have one
REAL = os.environ.get("T2L_GAIN_GRID", "")


def log(name, kp, omega, zeta):
    time, command, q = rows(omega, zeta, noise=1e-4, duration_s=3.0)
    still = np.zeros_like(command)
    return Recording(
        name=name, path=None, robot="fr3", joints=("a", "b"), kp=np.full(2, kp),
        kd=np.full(2, 4.0), command_rate_hz=50.0, control_rate_hz=1000.0,
        gravity_compensation=True, time=time, q_des=np.stack([command, still], axis=1),
        q=np.stack([q, still], axis=1),
    )  # fmt: skip


@pytest.fixture(scope="module")
def logs(tmp_path_factory):
    folder = tmp_path_factory.mktemp("logs")
    for name, kp, omega in (("one", 16.0, 8.0), ("two", 16.0, 8.0), ("stiff", 256.0, 32.0)):
        made = log(name, kp, omega, 8.0 / omega)
        write_recording(made, folder / name)
    return folder


@pytest.fixture(scope="module")
def dataset(tmp_path_factory):
    """Two episodes of one joint, in degrees."""
    folder = tmp_path_factory.mktemp("sets") / "reach"
    parts = [rows(12.0, 0.5, noise=1e-4, seed=seed, duration_s=3.0) for seed in (0, 1)]
    n = len(parts[0][0])
    table = {
        key: pa.array(np.rad2deg(np.concatenate([p[i] for p in parts]))[:, None].tolist(),
                      pa.list_(pa.float64()))
        for key, i in (("action", 1), ("observation.state", 2))
    }  # fmt: skip
    table |= {"episode_index": np.repeat([0, 1], n), "frame_index": np.tile(np.arange(n), 2)}
    (folder / "data/chunk-000").mkdir(parents=True)
    (folder / "meta").mkdir()
    pq.write_table(pa.table(table), folder / "data/chunk-000/file-000.parquet")
    feature = {"dtype": "float64", "shape": [1], "names": ["elbow.pos"]}
    info = {
        "codebase_version": "v3.0", "fps": 50, "total_frames": 2 * n,
        "features": {"action": feature, "observation.state": feature},
    }  # fmt: skip
    (folder / "meta/info.json").write_text(json.dumps(info))
    return folder


def test_recordings_of_the_same_gains_are_one_and_a_still_joint_is_left_out(logs):
    compliant, stiff = read_motions([logs])
    assert (compliant.label, stiff.label) == ("kp16_kd4", "kp256_kd4")
    assert len(compliant.rows) == 2
    (found,) = responses(compliant)
    assert found.joint == "a"
    assert found.region.name == "CU" if found.fit.zeta < 1 else "CO"


def test_a_data_set_of_degrees_and_without_a_model(dataset):
    (motions,) = read_motions([dataset])
    (found,) = responses(motions)
    assert found.fit.omega == pytest.approx(12.0, rel=0.02)
    assert found.fit.zeta == pytest.approx(0.5, rel=0.02)
    assert found.region.name == "CU"
    # from 2 ζ/ω of slow commands up to half a swing after steps
    assert 2 * 0.5 / 12.0 < found.lag.seconds < np.pi / 12.0


def test_the_command_writes_a_table_numbers_and_figures(logs, tmp_path, capsys):
    main(["gains", str(logs), "--out", str(tmp_path / "out")])
    said = capsys.readouterr().out
    assert "kp256_kd4" in said
    content = json.loads((tmp_path / "out/gains.json").read_text())
    compliant, stiff = content["joints"]
    low, high = stiff["omega_n_rad_s_ci95"]
    assert low < 32.0 < high or stiff["omega_n_rad_s"] == pytest.approx(32.0, rel=0.01)
    assert compliant["kp_logged"] == 16.0
    assert compliant["class"].startswith("C")
    assert stiff["class"].startswith("S")
    assert compliant["frequency_response"]["coherence"]
    assert (tmp_path / "out/figures/map.png").stat().st_size > 10_000
    assert (tmp_path / "out/figures/motions.pdf").is_file()


@pytest.mark.parametrize("rest", [0.0, 0.3, 1e4])
def test_of_a_joint_that_does_not_move_nothing_is_told(logs, tmp_path, capsys, rest):
    stuck = log("stuck", 16.0, 8.0, 1.0)
    write_recording(replace(stuck, q=np.full_like(stuck.q, rest)), tmp_path / "stuck")
    main(["gains", str(tmp_path / "stuck"), "--out", str(tmp_path / "out")])
    line = capsys.readouterr().out.splitlines()[1]
    assert line.endswith("does not move")
    assert line.count("not told") == 2
    (joint,) = json.loads((tmp_path / "out/gains.json").read_text())["joints"]
    assert (joint["explained"], joint["omega_n_rad_s_ci95"]) == (None, None)
    assert not joint["class_certain"]


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["LOGS", "--joints", "c"], "--joints: found c; allowed: a, b"),
        (["LOGS", "--joints", "b"], "no measured joint that is commanded to move"),
        (["LOGS", "--stiff-from-hz", "0"], "--stiff-from-hz: found 0; allowed"),
        (["LOGS", "--episodes", "1"], "--episodes: found recordings"),
        (["SET", "--episodes", "7"], "episode 7: found nothing; allowed: 0 to 1"),
        (["SET", "--joints", "wrist"], "wrist among the names"),
        (["SET", "LOGS"], "it beside other paths"),
        (["nowhere"], "nowhere: the path: found nothing; allowed: a LeRobot data set"),
        (["EMPTY"], "no recording"),
    ],
)
def test_what_is_wrong_is_said_before_anything_is_written(
    logs, dataset, tmp_path, capsys, arguments, said
):
    (tmp_path / "empty").mkdir()
    places = {"EMPTY": str(tmp_path / "empty"), "LOGS": str(logs), "SET": str(dataset)}
    with pytest.raises(SystemExit) as caught:
        main(["gains", *(places.get(a, a) for a in arguments), "--out", str(tmp_path / "out")])
    assert said in str(caught.value.code)
    assert not (tmp_path / "out").exists()


@pytest.mark.skipif(not Path(REAL).is_dir() or not REAL, reason="T2L_GAIN_GRID names no folder")
def test_real_joints_follow_more_the_stiffer_they_are():
    found = [r for motions in read_motions([Path(REAL)]) for r in responses(motions)]
    logged = np.array([r.logged for r in found])
    for joint in dict.fromkeys(r.joint for r in found):
        mine = np.array([r.joint == joint for r in found])
        for kd in np.unique(logged[:, 1]):
            cells = [r for r, (_, d), m in zip(found, logged, mine, strict=True) if m and d == kd]
            cells.sort(key=lambda r: r.logged[0])
            lags = [r.lag.seconds for r in cells if r.lag]
            assert np.corrcoef(np.argsort(np.argsort(lags)), np.arange(len(lags)))[0, 1] < -0.9


def test_what_is_hardly_measured_is_left_out():
    """Episodes may be empty, or hold nothing but gaps."""
    from t2l.response.joints import responses
    from t2l.response.motions import UNKNOWN, Motions

    time = np.arange(200) / 50
    command = np.sin(3 * time)[:, None]
    moved = np.sin(3 * time - 0.1)[:, None]
    gaps, nothing = np.full((200, 1), np.nan), np.zeros((0, 1))
    rows = ((time[:0], nothing, nothing), (time, command, gaps), (time, command, moved))
    (found,) = responses(Motions("set", ("a",), rows, UNKNOWN))
    assert len(found.rows) == 1
    assert responses(Motions("set", ("a",), rows[:2], UNKNOWN)) == []


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"kp": np.array([16.0, 0.0])}, "key kp: found joint b with kp 0"),
        ({"tau_ff": np.tile([0.0, 0.1], (150, 1))}, "column tau_ff.b: found a command beside"),
        ({"dq_des": np.tile([0.0, 0.1], (150, 1))}, "column dq_des.b: found a command beside"),
    ],
)
def test_a_joint_that_follows_something_else_is_refused_by_name(tmp_path, change, message):
    path = write_recording(replace(log("one", 16.0, 8.0, 1.0), **change), tmp_path / "one")
    with pytest.raises(RecordingError, match=message):
        read_motions([path])
    assert read_motions([path], ["a"])[0].joints == ("a",)
