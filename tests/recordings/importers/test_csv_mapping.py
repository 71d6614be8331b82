import os

import numpy as np
import pytest
import yaml

from t2l.cli.main import main
from t2l.errors import RecordingError
from t2l.recordings import read_recording
from t2l.recordings.importers import read_mapped, read_mapping
from tests.conftest import ROOT

TIME = np.arange(60) * 0.02
Q_DES = np.stack([0.1 * np.sin(3 * TIME), 0.2 * np.sin(2 * TIME) - 1], axis=1)
Q = Q_DES - 0.01
MAPPING = {
    "robot": "fr3",
    "joints": ["a", "b"],
    "kp": 64,
    "kd": [4, 2],
    "command_rate_hz": 50,
    "control_rate_hz": 1000,
    "gravity_compensation": True,
    "columns": {
        "time": {"from": "stamp", "unit": "us"},
        "q_des": {"from": ["cmd 0", "cmd 1"], "unit": "deg", "sign": [1, -1]},
        "q.a": {"from": "pos 0", "scale": 0.5, "offset": -3},
        "q.b": "pos 1",
    },
}


@pytest.fixture
def files(tmp_path):
    """A CSV in foreign units, as lines of cells, and its mapping."""
    degrees = np.rad2deg(Q_DES) * (1, -1)
    columns = [TIME * 1e6 + 5e15, *degrees.T, (Q[:, 0] + 3) / 0.5, Q[:, 1]]
    header = ["stamp", "cmd 0", "cmd 1", "pos 0", "pos 1", "extra"]
    rows = [header, *([*map(repr, map(float, row)), "text"] for row in np.stack(columns, axis=1))]
    (tmp_path / "run.csv").write_text("\n".join(map(",".join, rows)))
    (tmp_path / "map.yaml").write_text(yaml.safe_dump(MAPPING))
    return tmp_path / "run.csv", tmp_path / "map.yaml", rows


def test_units_signs_scales_and_offsets_are_undone(files):
    table, mapping, _ = files
    recording = read_mapped(table, read_mapping(mapping))
    np.testing.assert_allclose(recording.time, TIME, atol=1e-6)
    np.testing.assert_allclose(recording.q_des, Q_DES, atol=1e-12)
    np.testing.assert_allclose(recording.q, Q, atol=1e-12)
    assert recording.name == "run"
    assert recording.kd.tolist() == [4, 2]
    assert recording.dq is None


def test_one_column_may_be_the_supply_of_all_joints(files):
    table, mapping, _ = files
    lines = table.read_text().splitlines()
    table.write_text("\n".join([lines[0] + ",mV", *(line + ",7400" for line in lines[1:])]))
    columns = MAPPING["columns"] | {"supply_voltage": {"from": "mV", "unit": "mV"}}
    mapping.write_text(yaml.safe_dump(MAPPING | {"columns": columns}))
    recording = read_mapped(table, read_mapping(mapping))
    np.testing.assert_allclose(recording.supply_voltage, np.full_like(Q, 7.4))


def test_commanded_velocity_and_torque_come_in_other_units_and_are_held(tmp_path):
    joints = ["fr3_joint1", "fr3_joint2"]
    lines = ["t,p1,p2,c1,c2,v1,v2,u1,u2"]
    lines += [f"{0.02 * i},0,0,0,0,{'' if i % 2 else '90,180,500,-250'}" for i in range(30)]
    lines = [line + ",,," if line.endswith(",") else line for line in lines]
    table, mapping = tmp_path / "run.csv", tmp_path / "mapping.yaml"
    table.write_text("\n".join(lines))
    columns = {
        "time": "t", "q": ["p1", "p2"], "q_des": ["c1", "c2"],
        "dq_des": {"from": ["v1", "v2"], "unit": "deg/s"},
        "tau_ff": {"from": ["u1", "u2"], "unit": "mN·m"},
    }  # fmt: skip
    keys = MAPPING | {"joints": joints, "columns": columns, "held_commands": True}
    mapping.write_text(yaml.safe_dump(keys))
    recording = read_mapped(table, read_mapping(mapping))
    np.testing.assert_allclose(recording.dq_des, np.tile([np.pi / 2, np.pi], (30, 1)))
    np.testing.assert_allclose(recording.tau_ff, np.tile([0.5, -0.25], (30, 1)))


def test_the_command_writes_recordings(files, tmp_path, capsys):
    table, mapping, _ = files
    out = tmp_path / "out"
    line = ["import-csv", str(mapping), str(table), "--out", str(out), "--kp", "32", "--kd", "1"]
    main(line)
    assert capsys.readouterr().out == f"{out / 'run.csv'}\n"
    recording = read_recording(out / "run.csv")
    assert recording.cell == "kp32_kd1"
    np.testing.assert_allclose(recording.q, Q, atol=1e-12)
    with pytest.raises(SystemExit, match="found it twice"):
        main([*line[:2], str(table), *line[2:]])


@pytest.mark.parametrize("kind", ["table", "mapping", "another recording", "another format"])
def test_an_import_replaces_nothing_that_it_reads_or_that_is_there(files, tmp_path, kind):
    table, mapping, _ = files
    out = tmp_path / "out"
    main(["import-csv", str(mapping), str(table), "--out", str(out)])
    reading, force = [str(mapping), str(table)], []
    if kind == "table":
        # the recording's own table, under the mapping's names
        reading, force = [str(mapping), str(out / "run.csv")], ["--force"]
    elif kind == "mapping":
        (out / "run.yaml").write_text(mapping.read_text())
        reading, force = [str(out / "run.yaml"), str(table)], ["--force"]
    elif kind == "another format":
        force = ["--force", "--format", "parquet"]
    before = {path: path.read_bytes() for path in out.iterdir()}
    with pytest.raises(SystemExit, match="run"):
        main(["import-csv", *reading, "--out", str(out), *force])
    assert {path: path.read_bytes() for path in out.iterdir()} == before


def test_an_import_made_again_says_what_it_replaces(files, tmp_path, capsys):
    table, mapping, _ = files
    line = ["import-csv", str(mapping), str(table), "--out", str(tmp_path / "out")]
    main(line)
    main([*line, "--kp", "32", "--force"])
    assert "replacing" in (said := capsys.readouterr().err)
    assert "run.csv, run.yaml" in said
    assert read_recording(tmp_path / "out/run.csv").kp[0] == 32


def test_the_example_reads_decimal_commas_and_holds_commands(tmp_path):
    mapping = read_mapping(ROOT / "examples" / "csv_mapping.yaml")
    lines = [";".join(["stamp", *(f"{k}{i}" for i in range(1, 8) for k in ("cmd", "pos"))])]
    for row in range(40):
        command = "" if row % 2 or row == 0 else f"{row},5"
        lines.append(
            ";".join([str(1_700_000_000_000_000_000 + row * 10_000_000)] + [command, "90"] * 7)
        )
    table = tmp_path / "log.csv"
    table.write_text("\n".join(lines))
    recording = read_mapped(table, mapping)
    assert len(recording.time) == 38
    np.testing.assert_allclose(np.diff(recording.time), 0.01, atol=1e-6)
    np.testing.assert_allclose(recording.q_des[:4, 3], -np.deg2rad([2.5, 2.5, 4.5, 4.5]))
    np.testing.assert_allclose(
        recording.q[0], np.pi / 2 * np.array([1, 1, 1, -1, 1, 1, 1]) + np.eye(7)[6] * 0.785
    )


SPOILT = [
    ({"kp": -1}, "key kp: found -1"),
    ({"colums": {}}, r"key colums: found an unknown key \(did you mean columns\?\)"),
    ({"columns": None}, "key columns: found nothing"),
    ({"separator": ",", "decimal": ","}, "key decimal: found ','; allowed: another mark"),
    ({"decimal": "'"}, 'key decimal: found "\'"; allowed: ., ,'),
    ({"held_commands": 1}, "key held_commands: found 1; allowed: true or false"),
]

SPOILT_COLUMNS = [
    ({"time": None}, "key columns.time: found nothing"),
    ({"q.b": None}, "key columns.q.b: found nothing"),
    ({"q.b": 3}, "key columns.q.b: found 3"),
    ({"q.c": "x"}, "key columns.q.c: found an unknown key"),
    ({"q": ["pos 0", "pos 1"]}, "key columns.q.a: found a second source of q.a; allowed: one"),
    ({"q_des": ["cmd 0"]}, "key columns.q_des.from: found 1 columns; allowed: 2"),
    ({"q_des": {"from": "cmd 0"}}, r"key columns.q_des.from: found 'cmd 0'; allowed: a list"),
    ({"dq.a": "v"}, "key columns.dq.b: found nothing"),
    ({"time": {"from": "stamp", "unit": "min"}}, "key columns.time.unit: found 'min'; allowed: s,"),
    ({"q.b": {"from": "pos 1", "unit": "m"}}, "unit: found 'm'.*; allowed: rad, mrad, deg"),
    ({"q.b": {"unit": "rad"}}, "key columns.q.b.from: found nothing"),
    ({"q.b": {"from": "pos 1", "sign": 2}}, "key columns.q.b.sign: found 2; allowed: 1 or -1"),
    ({"q.b": {"from": "pos 1", "scale": 0}}, "key columns.q.b.scale: found 0; allowed: a number"),
    ({"q.b": {"from": "pos 1", "offset": "x"}}, "key columns.q.b.offset: found 'x'"),
    ({"q.b": {"form": "pos 1"}}, r"key columns.q.b.form: .*did you mean from\?"),
]


@pytest.mark.parametrize(("change", "message"), SPOILT, ids=str)
def test_a_wrong_mapping_is_named(files, change, message):
    _, mapping, _ = files
    mapping.write_text(yaml.safe_dump({**MAPPING, **change}))
    with pytest.raises(RecordingError, match=f"map.yaml: {message}"):
        read_mapping(mapping)


@pytest.mark.parametrize(("change", "message"), SPOILT_COLUMNS, ids=str)
def test_a_wrong_column_of_a_mapping_is_named(files, change, message):
    _, mapping, _ = files
    columns = {k: v for k, v in {**MAPPING["columns"], **change}.items() if v is not None}
    mapping.write_text(yaml.safe_dump({**MAPPING, "columns": columns}))
    with pytest.raises(RecordingError, match=f"map.yaml: .*{message}"):
        read_mapping(mapping)


def test_a_wrong_table_is_named(files):
    table, mapping, rows = files
    mapping = read_mapping(mapping)

    def spoil(row, column, cell):
        changed = [list(r) for r in rows]
        changed[row][column] = cell
        table.write_text("\n".join(map(",".join, changed)))

    spoil(3, 4, "broken")
    with pytest.raises(RecordingError, match=r"run.csv: row 3, column pos 1: found 'broken'"):
        read_mapped(table, mapping)
    spoil(0, 4, "pos_1")
    with pytest.raises(
        RecordingError, match=r"column pos 1, which .*map.yaml names: found nothing"
    ):
        read_mapped(table, mapping)
    spoil(3, 0, "5")
    with pytest.raises(
        RecordingError, match=r"row 3, column time, as mapped by .*map.yaml: found -"
    ):
        read_mapped(table, mapping)
    with pytest.raises(RecordingError, match=r"none.csv: the file: found nothing"):
        read_mapped(table.with_name("none.csv"), mapping)
    table.write_text("")
    with pytest.raises(RecordingError, match=r"run.csv: the file: found what is not CSV"):
        read_mapped(table, mapping)


def test_rows_of_one_stamp_become_one_and_their_number_is_said(files, caplog):
    table, mapping, rows = files
    rows[11][0] = rows[12][0]
    table.write_text("\n".join(map(",".join, rows)))
    recording = read_mapped(table, read_mapping(mapping))
    assert "1 of" in caplog.text
    np.testing.assert_allclose(recording.q, np.delete(Q, 10, axis=0), atol=1e-12)


def test_a_pipe_is_not_waited_for(files):
    table, mapping, _ = files
    table.unlink()
    os.mkfifo(table)
    with pytest.raises(RecordingError, match=r"run.csv: the file: found a named pipe \(FIFO\)"):
        read_mapped(table, read_mapping(mapping))
