"""Actuators are found again that all cells share, and what no cell shows is told."""

import dataclasses

import numpy as np
import pytest

from t2l.effects.actuator import Actuator
from t2l.effects.term import Layout, Term
from t2l.errors import ArtefactError
from t2l.gains import Cell
from t2l.hardware.identification_motion import identification_motion
from t2l.identify.known_gains import NAMES, identify_actuators, in_simulator
from t2l.identify.known_gains_artefacts import read_actuators, write_actuators
from t2l.identify.prediction import Predictor, Request
from t2l.recordings.recording import Recording
from t2l.robots import make_robot

ROBOT = make_robot("fr3")
TRUE = {
    "armature": [0.3, 0.3, 0.2, 0.2, 0.05, 0.05, 0.04],
    "friction": [1.0, 1.2, 0.8, 0.6, 0.5, 0.4, 0.2],
    "viscous_friction": [0.8, 0.9, 0.3, 0.2, 0.6, 0.1, 0.4],
    "torque_offset": [0.0, -0.1, 0.3, 0.0, 0.0, 0.1, -0.1],
    "torque_scale": [0.8, 0.9, 1.0, 1.1, 0.7, 0.9, 1.2],
}


@pytest.fixture(scope="module")
def recordings():
    """Two seconds of two cells, of a plant with known actuators and measured without noise."""
    blank = []
    for cell in (Cell(32, 4), Cell(256, 8)):
        motion = identification_motion(ROBOT, cell, 0.15, 2, "multisine")
        start = np.full_like(motion.q_des, np.nan)
        start[:] = motion.q_des[0]
        blank.append(
            Recording(
                name=cell.name, path=None, robot="fr3", joints=ROBOT.joints, kp=motion.kp,
                kd=motion.kd, command_rate_hz=50.0, control_rate_hz=1000.0,
                gravity_compensation=True, time=motion.time, q_des=motion.q_des, q=start,
                dq=np.zeros_like(start),
            )
        )  # fmt: skip
    predictor = Predictor("fr3", blank, threads=1)
    layout = Layout([Term(Actuator(), tuple(range(7)))])
    u = layout.encode({"actuator": {k: np.array(v) for k, v in TRUE.items()}})
    q, dq = predictor.predict([Request(layout, u[None])], velocity=True)
    positions, speeds = (predictor.samples.by_row(signal[0][0]) for signal in (q, dq))
    return [
        dataclasses.replace(r, q=position, dq=speed)
        for r, position, speed in zip(blank, positions, speeds, strict=True)
    ]


@pytest.fixture(scope="module")
def found(recordings):
    return identify_actuators(recordings, 15)


def test_what_made_the_recordings_is_found_again(found):
    for name, true in TRUE.items():
        np.testing.assert_allclose(found.values[name], true, rtol=0.02, atol=0.005)
    assert found.bounds == []
    assert found.losses.shape[1] == 2
    assert np.all(found.losses[-1] < 1e-3 * found.losses[0])


def test_a_cells_simulator_has_its_gains_times_the_scale(recordings, found):
    cell = in_simulator(recordings[1], found.values, found.bounds, found.losses[:, 1], 100)
    scale = found.values["torque_scale"]
    np.testing.assert_allclose(cell.parameters["stiffness"], 256 * scale)
    np.testing.assert_allclose(cell.parameters["damping"], 8 * scale)
    np.testing.assert_allclose(cell.parameters["dynamic_friction_ratio"], 1.0)
    # what is left is the simulator's coarse step and the constant torque that it lacks
    assert np.sqrt(cell.mse) < 0.01
    assert cell.s_star == cell.mse + cell.mse_dq


def test_a_joint_that_does_not_move_is_told_by_its_intervals(recordings):
    still = [dataclasses.replace(r, q=r.q.copy(), q_des=r.q_des.copy()) for r in recordings]
    for recording in still:
        recording.q[:, 6] = recording.q_des[:, 6] = ROBOT.home[6]
    unseen = identify_actuators(still, 2)
    low, high = unseen.intervals["torque_scale"][6]
    assert high / low > 10


def test_actuators_are_read_as_they_were_written(tmp_path, found):
    path = tmp_path / "actuators.yaml"
    bounds = [("friction", 2)]
    write_actuators(dataclasses.replace(found, bounds=bounds), ROBOT.joints, path)
    values, read = read_actuators(path)
    for name in NAMES:
        np.testing.assert_allclose(values[name], found.values[name], rtol=1e-5, atol=1e-12)
    assert read == bounds
    path.write_text(path.read_text().replace("armature: [", "armature: [.nan, "))
    with pytest.raises(ArtefactError, match="armature is not one finite number a joint"):
        read_actuators(path)
