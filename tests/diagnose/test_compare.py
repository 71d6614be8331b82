import dataclasses
import json

import numpy as np
import pytest

from t2l.diagnose.compare import compare, report, write
from t2l.diagnose.conditions import CONDITIONS
from t2l.diagnose.traces import binned, read_traces, spectrum
from t2l.effects.law import Curve, Law
from t2l.errors import ArtefactError, T2LError
from t2l.identify.model import Model
from tests.diagnose.made import measured, pendulum, recording, swing, swings, two_pendulums

FRICTION = {"coulomb_friction": {"torque": {"hinge": 0.06}}}
NOISE = 5e-5


@pytest.fixture(scope="module")
def robot(tmp_path_factory):
    return pendulum(tmp_path_factory.mktemp("robot"))


@pytest.fixture(scope="module")
def recordings(robot):
    return swings(robot, FRICTION, NOISE)


@pytest.fixture(scope="module")
def comparison(robot, recordings):
    return compare(Model(robot), recordings)


def test_a_true_model_is_left_with_the_noise(robot, recordings):
    found = compare(Model(robot, FRICTION), recordings)
    assert found.rmse_q_rad == pytest.approx(NOISE, rel=0.2)
    assert found.noise_floor_rad == pytest.approx(NOISE, rel=0.2)
    assert found.rmse_dq_rad_s is None


def test_a_lack_is_found_and_said(comparison):
    assert comparison.rmse_q_rad > 20 * comparison.noise_floor_rad
    assert comparison.explained[0].condition == "direction"
    assert comparison.findings[0].where == "at Kp 5"
    assert "of the squared error is hinge at Kp 5" in comparison.sentence


def test_numbers_of_the_report_agree(comparison):
    content = report(comparison)
    assert content["rmse_q_rad"] == comparison.rmse_q_rad
    logs, samples = content["logs"], content["samples"]
    assert [log["name"] for log in logs] == ["kp5", "kp20", "kp80"]
    pooled = sum(log["samples"] * log["rmse_q_rad"] ** 2 for log in logs) / samples
    assert np.sqrt(pooled) == pytest.approx(content["rmse_q_rad"])
    assert logs[0]["joints"]["hinge"]["rmse_q_rad"] == logs[0]["rmse_q_rad"]
    assert content["joints"]["hinge"]["share"] == pytest.approx(1.0)
    cells = {(c["joint"], c["kp"], c["kd"]): c["rmse_q_rad"] for c in content["cells"]}
    assert len(cells) == 6
    for log in logs:
        for joint in ("hinge", None):
            assert cells[joint, log["kp"][0], log["kd"][0]] == pytest.approx(log["rmse_q_rad"])


def test_what_is_written_can_be_read(comparison, tmp_path):
    write(comparison, tmp_path)
    assert sorted(p.name for p in tmp_path.iterdir()) == ["comparison.json", "traces.parquet"]
    content = json.loads((tmp_path / "comparison.json").read_text())
    assert content == json.loads(json.dumps(report(comparison)))
    traces = read_traces(tmp_path)
    assert traces.recordings == comparison.names
    assert traces.joints == ("hinge",)
    assert set(CONDITIONS) - set(traces.columns) == {"constant"}
    error = np.sqrt(np.mean(traces.error**2))
    assert error == pytest.approx(comparison.rmse_q_rad, rel=1e-3)
    assert len(traces.at(1, 0)) == 151


def test_a_missing_or_foreign_table_is_named(tmp_path):
    with pytest.raises(ArtefactError, match=r"traces\.parquet: no such file"):
        read_traces(tmp_path)
    (tmp_path / "traces.parquet").write_text("no table")
    with pytest.raises(ArtefactError, match="cannot be read"):
        read_traces(tmp_path)


def test_cells_not_sampled_are_left_out(robot, recordings):
    sparse = []
    for r in recordings:
        q = r.q.copy()
        q[1::3] = np.nan
        sparse.append(dataclasses.replace(r, q=q))
    found = compare(Model(robot), sparse)
    assert len(found.traces) == sum(int((~np.isnan(r.q)).sum()) for r in sparse)
    assert found.rmse_q_rad == pytest.approx(compare(Model(robot), recordings).rmse_q_rad, rel=0.1)


def test_velocity_counts_where_it_was_measured(robot, recordings):
    with_velocity = []
    for r in recordings:
        dq = np.gradient(r.q, r.time, axis=0)
        dq[::2] = np.nan
        with_velocity.append(dataclasses.replace(r, dq=dq))
    found = compare(Model(robot), [*with_velocity[:2], recordings[2]])
    content = report(found)
    assert content["rmse_dq_rad_s"] > 0
    assert [log["rmse_dq_rad_s"] is None for log in content["logs"]] == [False, False, True]
    assert "dq" in found.traces.column_names


def test_joints_with_gains_of_their_own_have_cells_of_their_own(tmp_path):
    both = recording(
        two_pendulums(tmp_path),
        lambda t: np.stack([swing()(t), swing(0.3, 1.1, -0.4)(t)], axis=1),
    )
    both = dataclasses.replace(both, kp=np.array([20.0, 5.0]), kd=np.array([0.8, 0.4]))
    content = report(compare(Model(both.robot), [measured(both, noise_rad=1e-4)]))
    cells = {(c["joint"], c["kp"], c["kd"]) for c in content["cells"]}
    assert {("left", 20.0, 0.8), ("right", 5.0, 0.4)} <= cells


def test_a_diverging_simulation_names_the_recording(robot, recordings):
    wild = dataclasses.replace(recordings[1], kp=np.array([1e6]), control_rate_hz=20.0, name="wild")
    with pytest.raises(T2LError, match="simulation of wild diverges"):
        compare(Model(robot), [recordings[0], wild])


def test_a_curve_that_lets_the_simulation_diverge_is_named(robot, recordings):
    # a negative damper that grows with the speed
    wild = Curve(Law("torque", "hinge", "velocity", "hinge"), (-1e6, 1e6), (-1e12, 1e12))
    fine = Curve(Law("torque", "hinge", "position", "hinge"), (-1.0, 1.0), (-0.01, 0.01))
    effects = {"viscous_friction": {"damping": {"hinge": 0.1}}}
    said = (
        "simulation of kp5.* diverges with learned_torque_hinge_velocity of the model, and does "
        "not without.*the recording is not at fault"
    )
    with pytest.raises(T2LError, match=said):
        compare(Model(robot, effects, learned=(fine, wild)), recordings[:2])


def test_recordings_of_other_joints_do_not_go_together(robot, recordings):
    other = dataclasses.replace(recordings[0], joints=("elbow",))
    with pytest.raises(T2LError, match="drives hinge"):
        compare(Model(robot), [recordings[0], other])
    with pytest.raises(T2LError, match="no recordings"):
        compare(Model(robot), [])


def test_contradicting_recordings_are_told(robot, recordings):
    other = dataclasses.replace(measured(recordings[0], None, NOISE, 9), name="again")
    found = compare(Model(robot), [recordings[0], other])
    assert [(c.first, c.second) for c in found.contradictions] == [("kp5", "again")]
    assert found.contradictions[0].message in json.dumps(report(found), ensure_ascii=False)


def test_means_in_bins_follow_the_function():
    x = np.random.default_rng(0).normal(size=5000)
    at, mean = binned(x, 3 * x)
    np.testing.assert_allclose(mean, 3 * at)
    assert len(at) > 10
    np.testing.assert_array_equal(binned(np.sign(x), np.sign(x))[0], [-1, 1])


def test_the_spectrum_has_the_power_of_the_error(tmp_path, comparison):
    write(comparison, tmp_path)
    traces = read_traces(tmp_path)
    rng = np.random.default_rng(0)
    noise = 1e-3 * rng.normal(size=len(traces.joint))
    white = dataclasses.replace(
        traces, columns=traces.columns | {"q": traces.columns["q_sim"] + noise}
    )
    frequency, density = spectrum(white, 0)
    assert frequency[0] == pytest.approx(1 / 1.5)
    assert frequency[-1] == pytest.approx(50, rel=0.02)
    # white noise of variance s² over a band of 50 Hz
    assert np.sqrt(np.mean(density**2) * 50) == pytest.approx(1e-3, rel=0.1)
