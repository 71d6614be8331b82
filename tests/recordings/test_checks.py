import numpy as np
import pytest

from t2l.errors import RecordingError
from t2l.recordings import read_recording
from t2l.recordings.checks import check_against_joint_ranges, check_samples
from tests.recordings.made import recording, written

CELLS = [
    (5, "time", "", r"row 5, column time: found nothing \(NaN\); allowed: a finite number, in s"),
    (5, "time", "0.05", "row 5, column time: found 0.05; allowed: at least the 0.06 s of the row"),
    (5, "time", "-1", "row 5, column time: found -1"),
    (5, "time", "inf", "row 5, column time: found inf"),
    (3, "q_des.b", "", r"row 3, column q_des.b: found nothing \(NaN\); allowed: a finite number$"),
    (3, "q_des.b", "-inf", "row 3, column q_des.b: found -inf"),
    (3, "q.a", "inf", "row 3, column q.a: found inf; allowed: a finite number, or nothing"),
    (3, "q.a", "n/a", "row 3, column q.a: found 'n/a'; allowed: a number, or nothing"),
    (7, "q.a", "0.1;0.2", "row 7, column q.a: found '0.1;0.2'"),
]


@pytest.mark.parametrize(("row", "column", "cell", "message"), CELLS)
def test_a_wrong_cell_is_named_by_row_and_column(tmp_path, row, column, cell, message):
    files = written(tmp_path)
    files.spoil_row(row, column, cell)
    with pytest.raises(RecordingError, match=f"swing.csv: {message}"):
        read_recording(files.table)


HEADERS = [
    ("q.b", "q.c", "column q.c: found an unknown column"),
    ("q_des.a", "qdes.a", r"column qdes.a: found an unknown column \(did you mean q_des.a\?\)"),
    ("q.b", "q.a", "column q.a: found it twice"),
    ("q.b", "dq.b", "column q.b: found nothing; allowed: q of each of the 2 joints"),
    ("time", "t", "column t: found an unknown column"),
]


@pytest.mark.parametrize(("old", "new", "message"), HEADERS)
def test_a_wrong_header_is_named(tmp_path, old, new, message):
    files = written(tmp_path)
    files.rows[0][files.rows[0].index(old)] = new
    files.save()
    with pytest.raises(RecordingError, match=f"swing.csv: {message}"):
        read_recording(files.table)


def test_a_missing_column_is_named(tmp_path):
    files = written(tmp_path)
    files.rows = [row[1:] for row in files.rows]
    files.save()
    with pytest.raises(RecordingError, match="column time: found nothing"):
        read_recording(files.table)


def test_velocities_of_some_joints_only_are_refused(tmp_path):
    files = written(tmp_path, dq=np.zeros((50, 2)))
    files.rows = [row[:-1] for row in files.rows]
    files.save()
    with pytest.raises(RecordingError, match=r"column dq.b: found nothing; .* or of none"):
        read_recording(files.table)


SWITCHES = [
    ({"torque_enabled": np.full((50, 2), 0.5)}, "column torque_enabled: found 0.5; allowed: 0"),
    ({"supply_voltage": np.zeros((50, 2))}, "column supply_voltage: found 0; allowed: above 0 V"),
    ({"temperature": np.full((50, 2), -300.0)}, "column temperature: found -300; allowed: above"),
    ({"current": np.full((50, 2), np.inf)}, "column current.a: found inf"),
]


@pytest.mark.parametrize(("changes", "message"), SWITCHES)
def test_a_switch_is_on_or_off_and_a_voltage_positive(changes, message):
    with pytest.raises(RecordingError, match=message):
        check_samples(recording(**changes))


def test_one_column_for_all_joints_or_one_for_each(tmp_path):
    files = written(tmp_path, supply_voltage=np.array([[7.0, 8.0]] * 50))
    files.rows[0][-1] = "supply_voltage"
    files.save()
    with pytest.raises(RecordingError, match="column supply_voltage: found columns of single"):
        read_recording(files.table)


def test_other_separators_and_ragged_rows_are_named(tmp_path):
    files = written(tmp_path)
    text = files.table.read_text()
    files.table.write_text(text.replace(",", ";"))
    with pytest.raises(RecordingError, match="allowed: columns separated by commas"):
        read_recording(files.table)
    files.table.write_text(text[: text.index("\n0.2,") + 10])
    with pytest.raises(RecordingError, match="row 11: found 2 cells; allowed: 5"):
        read_recording(files.table)


@pytest.mark.parametrize("content", [b"", b"PAR1", b"\xff\xfe\x00"])
@pytest.mark.parametrize("suffix", [".csv", ".parquet"])
def test_foreign_files_are_named(tmp_path, content, suffix):
    files = written(tmp_path)
    files.table.unlink()
    files.table.with_suffix(suffix).write_bytes(content)
    with pytest.raises(RecordingError, match=f"swing{suffix}: "):
        read_recording(files.table)


def test_an_unsampled_joint_and_short_recordings_are_named(tmp_path):
    files = written(tmp_path)
    rows = files.rows
    files.rows = rows[:15]
    files.save()
    with pytest.raises(RecordingError, match=r"column q.a: found 7 measured positions; .* 10"):
        read_recording(files.table)
    files.rows = [rows[0]] + [[str(float(r[0]) / 1000), *r[1:]] for r in rows[1:]]
    files.save()
    with pytest.raises(RecordingError, match=r"at least 0.2 s \(is time in seconds\?\)"):
        read_recording(files.table)
    files.rows = [rows[0]] + [[*r[:-1], ""] for r in rows[1:]]
    files.save()
    with pytest.raises(RecordingError, match=r"column q.b: found no measured position"):
        read_recording(files.table)


RANGES = np.array([[-np.inf, np.inf], [-2.5, 0.0], [-2.9, 2.9]])
MODEL = ("wrist", "b", "a")


def test_positions_within_ranges_pass():
    check_against_joint_ranges(recording(), RANGES, MODEL)


def test_an_unknown_joint_is_named_with_those_of_the_model():
    with pytest.raises(RecordingError, match=r"found a, which the model .*allowed: b, c"):
        check_against_joint_ranges(recording(), RANGES[:2], ("b", "c"))


@pytest.mark.parametrize("kind", ["q_des", "q"])
def test_positions_outside_a_range_are_named(kind):
    values = getattr(recording(), kind).copy()
    values[4, 1] = 0.3
    with pytest.raises(RecordingError, match=rf"row 5, column {kind}.b: found 0.3 rad; .* -2.5 to"):
        check_against_joint_ranges(recording(**{kind: values}), RANGES, MODEL)


def test_degrees_are_recognised():
    made = recording()
    in_degrees = recording(q_des=np.rad2deg(made.q_des), q=np.rad2deg(made.q))
    with pytest.raises(RecordingError, match=r"found .*looks like degrees \(-1.3 rad\)"):
        check_against_joint_ranges(in_degrees, RANGES, MODEL)
    with pytest.raises(RecordingError, match=r"column q.b: found .*looks like degrees"):
        check_against_joint_ranges(recording(q=in_degrees.q), RANGES, MODEL)


ADDED = {"dq_des": np.zeros((50, 2)), "tau_ff": np.ones((50, 2))}


@pytest.mark.parametrize("column", ADDED)
@pytest.mark.parametrize(
    ("cell", "found"), [("", r"nothing \(NaN\)"), ("inf", "inf"), ("1e300", "1e\\+300")]
)
def test_a_command_beside_the_position_is_a_number_at_every_row(tmp_path, column, cell, found):
    files = written(tmp_path, **ADDED)
    files.spoil_row(4, f"{column}.b", cell)
    with pytest.raises(RecordingError, match=rf"row 4, column {column}.b: found {found}; allowed"):
        read_recording(files.table)


@pytest.mark.parametrize(("column", "unit"), [("dq_des", "rad/s"), ("tau_ff", "N·m")])
def test_it_is_there_for_every_joint_or_for_none(tmp_path, column, unit):
    files = written(tmp_path, **{column: ADDED[column]})
    at = files.rows[0].index(f"{column}.b")
    files.rows = [row[:at] + row[at + 1 :] for row in files.rows]
    files.save()
    message = rf"column {column}.b: found nothing; .* 2 joints of the YAML, in {unit}, or of none"
    with pytest.raises(RecordingError, match=message):
        read_recording(files.table)


def test_a_recording_begins_where_every_joint_is_measured(caplog):
    made = recording(torque_enabled=np.full((50, 2), np.nan), **ADDED)
    made.q[:4, 1] = np.nan
    made.torque_enabled[1] = 0.0
    begun = check_samples(made)
    assert "first 4 of 50 rows (0.08 s) left out, as column q.b begins after them" in caplog.text
    np.testing.assert_array_equal(begun.time, made.time[4:])
    np.testing.assert_array_equal(begun.q_des, made.q_des[4:])
    np.testing.assert_array_equal(begun.tau_ff, made.tau_ff[4:])
    assert (begun.powered == 0).all()


def test_a_joint_that_is_measured_too_late_is_named():
    made = recording()
    made.q[:40, 1] = np.nan
    with pytest.raises(RecordingError, match=r"column q.b: found 5 measured positions; allowed"):
        check_samples(made)


def test_what_is_commanded_of_a_joint_without_stiffness_may_be_outside_its_range():
    made = recording(kp=0.0)
    ranges = np.array([[-1.0, 1.0], [-2.0, -1.2]])
    made.q_des[:] = 0.5
    check_against_joint_ranges(made, ranges, ("a", "b"))
    with pytest.raises(RecordingError, match=r"column q_des\.b"):
        check_against_joint_ranges(recording(q_des=made.q_des), ranges, ("a", "b"))
