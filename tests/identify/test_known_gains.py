"""Actuators are found again that all cells share, and what no cell shows is told."""

import dataclasses

import numpy as np
import pytest

from t2l.effects.actuator import Actuator
from t2l.effects.term import Layout, Term
from t2l.errors import ArtefactError
from t2l.gains import Cell
from t2l.hardware.excitation import envelope, multisine
from t2l.hardware.identification_motion import identification_motion
from t2l.identify.known_gains import NAMES, identify_actuators, in_simulator
from t2l.identify.known_gains_artefacts import read_actuators, write_actuators
from t2l.identify.prediction import Predictor, Request
from t2l.recordings.recording import Recording
from t2l.robots import make_robot
from tests.conftest import ROOT

ARM = str(ROOT / "examples/two_joint_arm/two_joint_arm.xml")
JOINTS = ("shoulder", "elbow")
TRUE = {
    "armature": [0.1, 0.02], "friction": [0.5, 0.2], "viscous_friction": [0.3, 0.1],
    "torque_offset": [0.1, -0.05], "torque_scale": [0.8, 1.2],
}  # fmt: skip


@pytest.fixture(scope="module")
def recordings():
    """Two cells of a plant with known actuators, 1.2 s each, measured without noise."""
    time = np.arange(60) / 50
    offsets = multisine(time, np.full(2, 0.4), np.arange(1, 6), seed=1)
    offsets *= envelope(time, time[-1], 0.4)[:, None]
    blank = [
        Recording(
            name=f"{kp:g}", path=None, robot=ARM, joints=JOINTS, kp=np.full(2, kp),
            kd=np.full(2, kd), command_rate_hz=50.0, control_rate_hz=250.0,
            gravity_compensation=True, time=time, q_des=offsets, q=np.tile(offsets[0], (60, 1)),
            dq=np.zeros((60, 2)),
        )
        for kp, kd in ((20.0, 1.0), (80.0, 2.0))
    ]  # fmt: skip
    predictor = Predictor(ARM, blank, threads=1)
    layout = Layout([Term(Actuator(), (0, 1))])
    u = layout.encode({"actuator": {k: np.array(v) for k, v in TRUE.items()}})
    q, dq = predictor.predict([Request(layout, u[None])], velocity=True)
    positions, speeds = (predictor.samples.by_row(signal[0][0]) for signal in (q, dq))
    return [
        dataclasses.replace(r, q=position, dq=speed)
        for r, position, speed in zip(blank, positions, speeds, strict=True)
    ]


@pytest.fixture(scope="module")
def found(recordings):
    return identify_actuators(recordings, 20)


def test_what_made_the_recordings_is_found_again(found):
    for name, true in TRUE.items():
        np.testing.assert_allclose(found.values[name], true, rtol=0.02, atol=1e-3, err_msg=name)
    assert found.bounds == []
    assert np.all(found.losses[-1] < 1e-4 * found.losses[0])


def test_a_joint_that_does_not_move_is_told_by_its_intervals(recordings):
    still = [dataclasses.replace(r, q=r.q.copy(), q_des=r.q_des.copy()) for r in recordings]
    for recording in still:
        recording.q[:, 1] = recording.q_des[:, 1] = 0.0
    unseen = identify_actuators(still, 2)
    low, high = unseen.intervals["torque_scale"][1]
    assert high / low > 10


def test_a_cells_simulator_has_its_gains_times_the_scale():
    robot = make_robot("fr3")
    motion = identification_motion(robot, Cell(128, 8), 0.15, 1)
    recording = Recording(
        name="still", path=None, robot="fr3", joints=robot.joints, kp=motion.kp, kd=motion.kd,
        command_rate_hz=50.0, control_rate_hz=1000.0, gravity_compensation=True, time=motion.time,
        q_des=motion.q_des, q=np.tile(robot.home, (50, 1)), dq=np.zeros_like(motion.q_des),
    )  # fmt: skip
    # so much friction that nothing moves
    values = {name: np.full(7, 0.5) for name in NAMES} | {"friction": np.full(7, 90.0)}
    cell = in_simulator(recording, values, [("friction", 3)], np.array([2.0, 1.0]), 100)
    np.testing.assert_allclose(cell.parameters["stiffness"], 64)
    np.testing.assert_allclose(cell.parameters["damping"], 4)
    np.testing.assert_allclose(cell.parameters["static_friction"], 90)
    np.testing.assert_allclose(cell.parameters["dynamic_friction_ratio"], 1)
    assert cell.mse < 1e-7
    assert cell.s_star == cell.mse + cell.mse_dq < 1e-6
    assert cell.bounds == [("friction", 3)]
    # S* counts velocities, and knows where there are none
    fast = dataclasses.replace(recording, dq=recording.dq + 0.1)
    again = in_simulator(fast, values, [], np.array([1.0]), 100)
    assert again.s_star > 1e-3 > again.mse
    silent = dataclasses.replace(recording, dq=None)
    assert np.isnan(in_simulator(silent, values, [], np.array([1.0]), 100).s_star)


def test_actuators_are_read_as_they_were_written(tmp_path, found):
    path = tmp_path / "actuators.yaml"
    bounds = [("friction", 1)]
    write_actuators(dataclasses.replace(found, bounds=bounds), JOINTS, path)
    values, read = read_actuators(path)
    for name in NAMES:
        np.testing.assert_allclose(values[name], found.values[name], rtol=1e-5, atol=1e-12)
    assert read == bounds
    path.write_text(path.read_text().replace("armature: [", "armature: [.nan, "))
    with pytest.raises(ArtefactError, match="armature is not one finite number a joint"):
        read_actuators(path)
