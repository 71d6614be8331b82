"""A drive that is a DC motor under a voltage: its YAML, and what it is in N·m."""

import numpy as np
import pytest

from t2l.errors import RecordingError
from t2l.recordings import read_recording, write_recording
from t2l.recordings.motor import Motor
from tests.recordings.made import Files, recording

KT, RESISTANCE, SUPPLY = np.array([0.3, 0.6]), np.array([2.0, 4.0]), np.array([8.0, 8.0])
MOTOR = Motor(KT, RESISTANCE, SUPPLY)
STALL = np.array([1.2, 1.2])  # N·m
DUTY = np.stack([np.linspace(-1, 1, 50), np.linspace(0, 0.5, 50)], axis=1)


def written(folder, motor=MOTOR, **changes):
    made = recording(**{"kp": 24.0, "kd": 1.2, "motor": motor, **changes})
    return Files(write_recording(made, folder / made.name))


def of_duty(folder, **changes):
    return written(folder, control="duty", kp=0.0, kd=0.0, tau_ff=DUTY * STALL, **changes)


def test_gains_of_duty_are_gains_of_torque(tmp_path):
    files = written(tmp_path)
    assert (files.keys["kp"], files.keys["kd"]) == (20, 1)  # duty/rad and duty·s/rad
    found = read_recording(files.table)
    assert found.kp == pytest.approx([24, 24])
    assert found.kd == pytest.approx([1.2, 1.2])
    assert found.stall == pytest.approx(STALL)
    assert found.back_emf == pytest.approx(KT**2 / RESISTANCE)


def test_a_duty_is_a_torque(tmp_path):
    files = of_duty(tmp_path)
    assert "duty.a" in files.rows[0]
    assert files.rows[1][files.rows[0].index("duty.a")] == "-1.0"
    found = read_recording(files.table)
    assert found.tau_ff == pytest.approx(DUTY * STALL)
    assert (found.kp == 0).all()


def test_a_gear_is_in_the_torque_constant(tmp_path):
    files = written(tmp_path)
    files.spoil_key("motor", {"kt": 0.003, "gear": [100, 200], "resistance": [2, 4], "supply": 8})
    assert read_recording(files.table).motor.kt == pytest.approx(KT)


def test_gains_follow_a_logged_supply(tmp_path):
    voltage = np.repeat(np.linspace(9, 7, 50)[:, None], 2, axis=1)
    voltage[1::2] = np.nan
    files = written(tmp_path, Motor(KT, RESISTANCE, SUPPLY, logged=True), supply_voltage=voltage)
    assert files.keys["motor"]["supply"] == "supply_voltage"
    found = read_recording(files.table)
    middle = np.nanmedian(voltage)
    assert found.motor.supply == pytest.approx(middle)
    assert found.kp == pytest.approx(20 * 0.15 * middle)
    # each voltage holds until the next
    assert found.supply[:2, 0] == pytest.approx(9 / middle)
    again = write_recording(found, tmp_path / "again")
    assert Files(again).keys["kp"] == 20


@pytest.mark.parametrize(
    ("motor", "message"),
    [
        ({"kt": 0.3, "resistance": 2}, "key motor.supply: found nothing; allowed: numbers, in V"),
        ({"kt": 0.3, "resistance": 0, "supply": 8}, "key motor.resistance: found 0; allowed: one"),
        ({"kt": [1], "resistance": 2, "supply": 8}, "key motor.kt: found 1 number; allowed: .*2,"),
        ({"kt": 1, "resistance": 2, "supply": -8}, "key motor.supply: found -8; allowed: one"),
        ({"kt": 1, "resistance": 2, "supply": "battery"}, "key motor.supply: found 'battery'"),
        ({"kt": 1, "resistance": 2, "supply": 8, "poles": 3}, "key motor.poles: found an unknown"),
        ({"kt": 1, "resistance": 2, "supply": "supply_voltage"}, "column supply_voltage: found"),
        ("dc", "key motor: found 'dc'"),
    ],
)  # fmt: skip
def test_a_wrong_motor_is_named(tmp_path, motor, message):
    files = written(tmp_path)
    files.spoil_key("motor", motor)
    with pytest.raises(RecordingError, match=message):
        read_recording(files.table)


def test_what_a_motor_does_not_take_is_named(tmp_path):
    files = written(tmp_path)
    files.rows = [
        row + (["0", "0"] if i else ["tau_ff.a", "tau_ff.b"]) for i, row in enumerate(files.rows)
    ]
    files.save()
    with pytest.raises(
        RecordingError, match=r"column tau_ff\.a: found a torque, where the YAML has"
    ):
        read_recording(files.table)


def test_a_duty_beyond_full_is_named(tmp_path):
    files = of_duty(tmp_path)
    files.spoil_row(4, "duty.b", "1.5")
    with pytest.raises(
        RecordingError, match=r"row 4, column duty\.b: found 1\.5; allowed: a share"
    ):
        read_recording(files.table)


def test_duty_needs_a_motor_and_torque_takes_none(tmp_path):
    files = of_duty(tmp_path)
    motor = files.keys.pop("motor")
    files.save()
    with pytest.raises(RecordingError, match="key motor: found nothing; allowed: the keys kt, res"):
        read_recording(files.table)
    files.keys |= {"motor": motor, "control": "torque"}
    files.save()
    with pytest.raises(RecordingError, match="key motor: found it, where control is torque"):
        read_recording(files.table)
