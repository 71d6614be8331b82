import numpy as np
import pytest

from t2l.advise.attenuation import step_matrices
from t2l.gains import Cell
from t2l.robots import ROBOTS, make_robot
from t2l.sim import apply_position_gains, make_batch
from t2l.sim.batch import TIMESTEP_S
from t2l.study.attenuation.rack import COLUMNS, held_noise, make_rack

# h Kp / (2 Kd) is 0.04, 0.08 and 2.56
CELLS = [Cell(128, 32), Cell(256, 32), Cell(512, 2)]


@pytest.fixture(scope="module")
def held():
    rack = make_rack(make_robot("fr3"), (0.02, 0.2))
    return held_noise(rack, CELLS, 0.01, 10, 160, 20, np.random.default_rng(0), threads=2)


@pytest.mark.parametrize("name", ROBOTS.names())
def test_a_step_is_the_one_that_theory_takes(name):
    rack = make_rack(make_robot(name), (0.05,), copies=2)
    names = [joint for joints in rack.joints.values() for joint in joints]
    batch = make_batch(rack.model, 1)
    apply_position_gains(batch, names, 2048.0, 8.0)
    # far more torque than any robot has: its limits are not in it
    batch.bind("ctrl")[:] = 3.0
    states = {plant: np.zeros(2) for plant in rack.joints}
    for _ in range(40):
        batch.step()
        for plant, joints in rack.joints.items():
            a, b = step_matrices(2048.0, 8.0, rack.inertia[plant], TIMESTEP_S)
            states[plant] = a @ states[plant] + 3.0 * b
            for joint in joints:
                address = rack.model.joint(joint).qposadr[0]
                assert batch.qpos[0, address] == pytest.approx(states[plant][0], abs=1e-9)


def test_one_row_a_plant_and_cell(held):
    assert tuple(held.columns) == COLUMNS
    assert len(held) == 3 * len(CELLS)
    assert (held.replicates == 160).all()
    assert set(held.hold_s) == {0.02}


def test_the_simulated_variance_is_the_exact_one(held):
    beyond = (held.variance_rad2 - held.exact_rad2).abs() / held.variance_rad2_se
    assert beyond.max() < 4
    assert (held.variance_rad2_se / held.variance_rad2).max() < 0.05


def test_the_theorem_holds_where_it_is_small_and_only_there(held):
    ratio = held.variance_rad2 / held.theorem_rad2
    small = held.theorem_rad2 / held.noise_rad**2 < 0.1
    assert (ratio[small] - 1).abs().max() < 0.1
    assert ratio[~small].max() < 0.8


def test_replicates_are_rounded_up_to_whole_racks():
    rack = make_rack(make_robot("fr3"), (0.1,))
    table = held_noise(rack, [Cell(512, 32)], 0.01, 10, 5, 0.1, np.random.default_rng(0))
    assert (table.replicates == 8).all()
