"""Tables and YAMLs of drives that follow torques or velocities."""

import numpy as np
import pytest
import yaml

from t2l.errors import RecordingError
from t2l.recordings import read_recording, write_recording
from t2l.recordings.importers.csv_mapping import read_mapped, read_mapping
from t2l.recordings.recording import held
from tests.recordings.made import JOINTS, Files, recording

PUSHED = np.stack([np.linspace(-1, 1, 50), np.linspace(0, 3, 50)], axis=1)


def written(folder, control="torque", **changes):
    """A log of commanded torques or velocities, to be spoilt."""
    command = {"torque": "tau_ff", "velocity": "dq_des"}[control]
    gains = {"kp": 0.0, "kd": 2.0 if control == "velocity" else 0.0}
    made = recording(control=control, **gains, **{command: PUSHED}, **changes)
    return Files(write_recording(made, folder / made.name))


@pytest.mark.parametrize("control", ["torque", "velocity"])
def test_what_is_written_is_read(tmp_path, control):
    files = written(tmp_path, control)
    column = {"torque": "tau_des", "velocity": "dq_des"}[control]
    assert files.rows[0] == ["time", *(f"{kind}.{j}" for kind in (column, "q") for j in JOINTS)]
    assert files.keys["control"] == control
    assert ("kd" in files.keys) == (control == "velocity")
    assert "kp" not in files.keys
    found = read_recording(files.table)
    assert found.control == control
    assert np.array_equal(found.tau_ff if control == "torque" else found.dq_des, PUSHED)
    assert (found.kp == 0).all()
    # no command of a position: it is where the joint is
    assert np.array_equal(found.q_des, held(found.q))


def test_joints_that_begin_late_are_cut_as_elsewhere(tmp_path):
    files = written(tmp_path)
    for row in range(1, 8):
        files.spoil_row(row, "q.b", "")
    found = read_recording(files.table)
    assert not np.isnan(found.q_des).any()
    assert not np.isnan(found.q[0]).all()


@pytest.mark.parametrize(
    ("control", "column", "message"),
    [
        ("torque", "tau_des.b", r"column tau_des.b: found nothing; allowed: .*control is torque"),
        ("velocity", "dq_des.a", r"column dq_des.a: found nothing; allowed: .*control is velocity"),
        ("torque", "q.a", r"column q.a: found nothing"),
    ],
)
def test_a_missing_column_is_named(tmp_path, control, column, message):
    files = written(tmp_path, control)
    at = files.rows[0].index(column)
    files.rows = [row[:at] + row[at + 1 :] for row in files.rows]
    files.save()
    with pytest.raises(RecordingError, match=message):
        read_recording(files.table)


@pytest.mark.parametrize(
    ("control", "column", "message"),
    [
        ("torque", "q_des", "column q_des.a: found a command of control: position, where control "
         "is torque; allowed: commands in tau_des"),
        ("torque", "tau_ff", "column tau_ff.a: found a command of control: position or velocity"),
        ("velocity", "tau_des", "column tau_des.a: found a command of control: torque, where"),
    ],
)  # fmt: skip
def test_a_command_of_another_control_is_named(tmp_path, control, column, message):
    files = written(tmp_path, control)
    files.rows = [row + (["0"] * 2 if i else [f"{column}.{j}" for j in JOINTS])
                  for i, row in enumerate(files.rows)]  # fmt: skip
    files.save()
    with pytest.raises(RecordingError, match=message):
        read_recording(files.table)


@pytest.mark.parametrize(
    ("control", "key", "value", "message"),
    [
        ("torque", "kp", 20, "key kp: found 20, where control is torque; allowed: no such key, or "
         "0; a control that has it: position"),
        ("torque", "kd", [0, 1], r"key kd: found \[0, 1\], where control is torque"),
        ("velocity", "kp", 3, "key kp: found 3, where control is velocity"),
        ("velocity", "kd", None, "key kd: found nothing"),
        ("velocity", "kd", 0, "key kd: found 0; allowed: above 0"),
        ("torque", "control", "current", "key control: found 'current'; allowed: position, "),
        ("torque", "control", "position", "key kp: found nothing"),
    ],
)  # fmt: skip
def test_a_wrong_key_is_named(tmp_path, control, key, value, message):
    files = written(tmp_path, control)
    files.spoil_key(key, value)
    with pytest.raises(RecordingError, match=message):
        read_recording(files.table)


def test_a_torque_that_is_no_number_is_named(tmp_path):
    files = written(tmp_path)
    files.spoil_row(3, "tau_des.b", "")
    with pytest.raises(RecordingError, match=r"row 3, column tau_des.b: found nothing \(NaN\)"):
        read_recording(files.table)


def test_a_csv_of_torques_is_imported(tmp_path):
    rows = [f"{t},{t},{2 * t},{t / 10},{t / 5}" for t in np.arange(50) / 50]
    (tmp_path / "own.csv").write_text("\n".join(["t,u0,u1,x0,x1", *rows]))
    mapping = {
        "robot": "fr3", "joints": list(JOINTS), "control": "torque", "command_rate_hz": 50,
        "control_rate_hz": 1000, "gravity_compensation": False,
        "columns": {
            "time": "t",
            "tau_des": {"from": ["u0", "u1"], "unit": "mNm"},
            "q": ["x0", "x1"],
        },
    }  # fmt: skip
    (tmp_path / "mapping.yaml").write_text(yaml.safe_dump(mapping))
    found = read_mapped(tmp_path / "own.csv", read_mapping(tmp_path / "mapping.yaml"))
    assert found.tau_ff[-1] == pytest.approx([0.98e-3, 1.96e-3])
    assert np.array_equal(found.q_des, found.q)
