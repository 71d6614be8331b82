import dataclasses
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from t2l.errors import InputError, RecordingError
from t2l.recordings import read_recording, read_recordings, write_recording
from t2l.recordings.checks import MOST_RAD
from t2l.recordings.metadata import as_written, check_metadata
from t2l.robots import ROBOTS
from tests.conftest import ROOT
from tests.recordings.made import recording, written

FR3_GRID = ROOT / "../shared/data/fr3_gain_grid"

finite = st.floats(min_value=-MOST_RAD, max_value=MOST_RAD)
measured = st.one_of(finite, st.just(float("nan")))
gains = st.floats(min_value=1e-3, max_value=1e4)
# rows may be minutes apart where commands are
rates = st.floats(min_value=0.01, max_value=20)


@st.composite
def recordings(draw):
    n, njoint = draw(st.integers(10, 20)), draw(st.integers(1, 3))
    steps = draw(st.lists(st.floats(min_value=0.03, max_value=5.0), min_size=n, max_size=n))

    def matrix(elements):
        values = draw(st.lists(elements, min_size=n * njoint, max_size=n * njoint))
        return np.array(values).reshape(n, njoint)

    def one_each(elements):
        return np.array(draw(st.lists(elements, min_size=njoint, max_size=njoint)))

    optional = st.booleans()
    return dataclasses.replace(
        recording(),
        joints=tuple(f"joint {i}" for i in range(njoint)),
        kp=one_each(gains),
        kd=one_each(gains),
        command_rate_hz=draw(rates),
        gravity_compensation=draw(st.sampled_from([True, False, "continuous"])),
        time=np.cumsum(steps),
        q_des=matrix(finite),
        q=matrix(finite),
        dq=matrix(measured) if draw(optional) else None,
        tau=matrix(measured) if draw(optional) else None,
        current=matrix(measured) if draw(optional) else None,
        supply_voltage=matrix(st.floats(1, 60) | st.just(np.nan)) if draw(optional) else None,
        temperature=matrix(st.floats(-40, 120) | st.just(np.nan)) if draw(optional) else None,
        torque_enabled=matrix(st.sampled_from([0.0, 1.0, np.nan])) if draw(optional) else None,
        base_position=tuple(draw(st.lists(finite, min_size=3, max_size=3))),
        notes=draw(st.sampled_from(["", "Größe: 2 × 'x'", "two\nlines"])),
    )


@settings(max_examples=40, deadline=None)
@given(made=recordings(), format=st.sampled_from(["csv", "parquet"]))
def test_what_is_written_is_read(made, format):
    with tempfile.TemporaryDirectory() as folder:
        path = write_recording(made, Path(folder) / "kp0.5_kd2", format)
        read = read_recording(path)
    assert read.name == "kp0.5_kd2"
    assert read.path == path
    for field in dataclasses.fields(made):
        if field.name not in ("name", "path"):
            expected, found = getattr(made, field.name), getattr(read, field.name)
            np.testing.assert_array_equal(found, expected, err_msg=field.name)


def test_a_recording_is_found_by_table_yaml_or_stem(tmp_path):
    files = written(tmp_path, name="kp0.5_kd2")
    for path in (files.table, files.yaml, tmp_path / "kp0.5_kd2"):
        assert read_recording(path).path == files.table


def test_a_slow_sensor_keeps_its_gaps(tmp_path):
    read = read_recording(written(tmp_path).table)
    assert np.isnan(read.q[1::2]).all()
    assert not np.isnan(read.q[::2]).any()
    assert read.duration_s == pytest.approx(0.98)


def test_a_folder_stands_for_its_recordings_each_once(tmp_path):
    for name in ("b", "a", "c"):
        written(tmp_path, name=name)
    names = [r.name for r in read_recordings([tmp_path / "c.csv", tmp_path, tmp_path / "a"])]
    assert names == ["c", "a", "b"]
    assert [r.name for r in read_recordings(tmp_path)] == ["a", "b", "c"]


def test_what_a_killed_process_left_is_no_recording(tmp_path):
    files = written(tmp_path)
    (tmp_path / ".swing.draft-0a1b2c3d.csv").write_bytes(files.table.read_bytes()[:100])
    assert [r.name for r in read_recordings(tmp_path)] == ["swing"]


def test_a_folder_without_recordings_is_named(tmp_path):
    with pytest.raises(RecordingError, match=f"{tmp_path}: .*found no recording"):
        read_recordings([tmp_path])


def test_a_table_without_yaml_and_a_yaml_without_table_are_named(tmp_path):
    files = written(tmp_path)
    content = files.yaml.read_text()
    files.yaml.unlink()
    with pytest.raises(InputError, match=r"swing.yaml: the file: found nothing"):
        read_recordings([tmp_path])
    files.yaml.write_text(content)
    files.table.unlink()
    with pytest.raises(RecordingError, match=r"found neither; allowed: one of swing.csv, swing.p"):
        read_recordings([tmp_path])


def test_two_tables_of_one_name_are_refused(tmp_path):
    files = written(tmp_path)
    with pytest.raises(RecordingError, match=r"swing.parquet: .*found swing.csv"):
        write_recording(recording(), files.table, format="parquet")
    (tmp_path / "swing.parquet").touch()
    with pytest.raises(RecordingError, match=r"found swing.csv and swing.parquet"):
        read_recording(files.table)


def test_a_recording_that_could_not_be_read_is_not_written(tmp_path):
    with pytest.raises(RecordingError, match="column time"):
        write_recording(recording(time=-np.arange(50.0)), tmp_path / "x")
    with pytest.raises(RecordingError, match="key kp"):
        write_recording(recording(kp=-1.0), tmp_path / "x")
    assert os.listdir(tmp_path) == []


def test_a_model_is_found_beside_the_yaml_wherever_both_go(tmp_path):
    model = tmp_path / "models" / "arm.xml"
    model.parent.mkdir()
    model.write_text("<mujoco/>")
    write_recording(recording(robot=str(model)), tmp_path / "runs" / "x")
    tmp_path.joinpath("moved").mkdir()
    for name in ("models", "runs"):
        (tmp_path / name).rename(tmp_path / "moved" / name)
    read = read_recording(tmp_path / "moved" / "runs" / "x")
    assert read.robot == str(tmp_path / "moved" / "models" / "arm.xml")


def test_a_cell_names_equal_gains_and_the_recording_other_ones():
    assert recording(kp=64.0, kd=4.0).cell == "kp64_kd4"
    assert recording(kd=0.0).cell == "swing"
    assert dataclasses.replace(recording(), kp=np.array([64.0, 32.0])).cell == "swing"


@pytest.mark.parametrize("robot", ROBOTS.names())
def test_a_known_robot_is_written_and_read_by_its_name(tmp_path, robot):
    made = dataclasses.replace(recording(), robot=robot)
    metadata = as_written(made, tmp_path / "swing.yaml")
    assert metadata["robot"] == check_metadata(metadata, tmp_path / "swing.yaml")["robot"] == robot


@pytest.mark.skipif(not FR3_GRID.is_dir(), reason=f"the recordings of {FR3_GRID} are not here")
def test_the_recordings_of_a_real_robot_are_read_in_no_time():
    start = time.perf_counter()
    grid = read_recordings(FR3_GRID)
    assert time.perf_counter() - start < 1.0
    assert len(grid) == 49
    assert {r.cell for r in grid} == {r.name for r in grid}
    assert all(r.q_des.shape == (200, 7) for r in grid)
    assert all((~np.isnan(r.q)).sum() == 700 for r in grid)


def test_reading_imports_nothing_slow():
    code = "import sys, t2l.recordings; sys.exit('pandas' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code]).returncode == 0


def test_one_column_stands_for_all_joints_and_holds_until_the_next_value(tmp_path):
    on = np.repeat(np.array([1.0] * 20 + [0.0] + [np.nan] * 29)[:, None], 2, axis=1)
    files = written(tmp_path, torque_enabled=on, supply_voltage=np.full((50, 2), 7.4))
    assert {"torque_enabled", "supply_voltage"} <= set(files.rows[0])
    read = read_recording(files.table)
    np.testing.assert_array_equal(read.torque_enabled, on)
    np.testing.assert_array_equal(read.powered[:, 1], [1.0] * 20 + [0.0] * 30)
    assert read.held("torque_enabled")[:, 0].tolist() == [1.0] * 20 + [0.0] * 30
    assert read.has("supply_voltage")
    assert not read.has("temperature")
    assert read.beginning(0.2).torque_enabled.shape == (10, 2)


def test_rows_of_one_stamp_are_one_in_which_the_last_value_of_each_column_counts(tmp_path, caplog):
    """Row 5 was sampled and row 6 was not, so the sample of row 5 stands beside its command."""
    files = written(tmp_path, dq=np.arange(100.0).reshape(50, 2))
    time, command, q = (files.rows[0].index(name) for name in ("time", "q_des.a", "q.a"))
    files.spoil_row(6, "time", files.rows[5][time])
    files.spoil_row(20, "time", files.rows[22][time])
    files.spoil_row(21, "time", files.rows[22][time])
    read = read_recording(files.table)

    assert "3 of 50 rows left out" in caplog.text
    assert (np.diff(read.time) > 0).all()
    assert len(read.time) == 47
    assert read.q_des[4, 0] == float(files.rows[6][command])
    assert read.q[4, 0] == float(files.rows[5][q])
    assert read.dq[4, 0] == 10
    assert read.time[18] == float(files.rows[22][time])
    assert read.q[18, 0] == float(files.rows[21][q])
    assert read.q_des[18, 0] == float(files.rows[22][command])
    whole = recording(dq=np.arange(100.0).reshape(50, 2))
    for kind in ("q_des", "q", "dq"):
        rest = [*range(4), *range(19, 47)]
        read_at = [*range(4), *range(22, 50)]
        np.testing.assert_array_equal(getattr(read, kind)[rest], getattr(whole, kind)[read_at])


def test_faults_beyond_repeated_stamps_are_named_by_the_rows_of_the_file(tmp_path):
    files = written(tmp_path)
    files.spoil_row(5, "time", files.rows[4][0])
    files.spoil_row(9, "q.a", "inf")
    with pytest.raises(RecordingError, match=r"row 9, column q.a: found inf"):
        read_recording(files.table)


def test_what_repeated_stamps_leave_must_be_enough(tmp_path):
    files = written(tmp_path)
    for row in range(1, 41):
        files.spoil_row(row, "time", "0.01")
    with pytest.raises(RecordingError, match="found 6 measured positions"):
        read_recording(files.table)


def test_rows_of_one_stamp_are_written_as_one(tmp_path):
    made = recording()
    time = made.time.copy()
    time[7] = time[8]
    written_back = read_recording(write_recording(recording(time=time), tmp_path / "swing"))
    np.testing.assert_array_equal(written_back.time, np.delete(time, 7))


@pytest.mark.parametrize("name", ["swing.csv", "swing.parquet", "swing.yaml"])
def test_a_pipe_is_not_waited_for(tmp_path, name):
    write_recording(recording(), tmp_path / "swing", "parquet" if "parquet" in name else "csv")
    (tmp_path / name).unlink()
    os.mkfifo(tmp_path / name)
    for path in (tmp_path / "swing", tmp_path):
        with pytest.raises(InputError, match=rf"{name}: the file: found a named pipe \(FIFO\)"):
            read_recordings(path)
