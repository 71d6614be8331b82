import numpy as np
import pandas as pd
import pytest

from t2l.actions import make_control
from t2l.demos.replay import replay
from t2l.gains import Cell
from t2l.study.attenuation.noise import (
    COLUMNS,
    TRACES,
    magnitudes,
    noise_table,
    noisy_replays,
    traces,
    uniform,
)
from t2l.study.attenuation.success import by_cell, predictors


def _control(task, cell):
    return make_control({"kind": "joint_target"}, cell, task.robot, task.model)


def test_seeds_of_a_cell_are_one_observation():
    rows = [(32, 2, 0.2, 0.01), (32, 2, 0.4, 0.03), (512, 2, 0.0, 0.0001)]
    cells = by_cell(pd.DataFrame(rows, columns=["kp", "kd", "success", "validation_mse_rad2"]))
    assert cells.seeds.tolist() == [2, 1]
    assert cells.success.tolist() == pytest.approx([0.3, 0.0])
    assert cells.loss.tolist() == pytest.approx([0.02, 0.0001])
    told = predictors(cells, 0.02)
    # √(0.02 × 32 / 4 × 0.02), √(0.02 × 512 / 4 × 0.0001)
    assert told.effective_error.tolist() == pytest.approx([0.0565685, 0.016])
    assert told.damping_over_stiffness.tolist() == pytest.approx([1 / 16, 1 / 256])
    # √((0.02 + 0.0001) / 2)
    sizes = magnitudes(cells, Cell(512, 2))
    assert sizes == {"same": pytest.approx(0.1002497), "own": pytest.approx(0.01)}


def test_noise_is_on_the_commands_and_within_its_magnitude(task, demonstrations):
    control, rng = _control(task, Cell(128, 32)), np.random.default_rng(0)
    clean = replay(task, demonstrations[:2], control, 10)
    noisy = noisy_replays(task, demonstrations[:2], control, 10, "mean", 0.02, 4, rng)
    assert len(noisy) == 4
    added = [b.command - clean[i % 2].command for i, b in enumerate(noisy)]
    assert all(np.abs(a).max() <= 0.02 for a in added)
    # of standard deviation 0.02 / √3, anew for each command and joint
    assert np.concatenate(added).std() == pytest.approx(0.02 / np.sqrt(3), rel=0.05)
    assert not np.allclose(added[0], added[2])
    table = noise_table(noisy, control.cell, "same", 0.02)
    assert set(COLUMNS) == set(table.columns)


def test_without_magnitude_nothing_changes(task, demonstrations):
    control = _control(task, Cell(128, 32))
    clean = replay(task, demonstrations[:1], control, 10)[0]
    still = replay(
        task, demonstrations[:1], control, 10, noise=uniform(0.0, np.random.default_rng(0))
    )[0]
    np.testing.assert_array_equal(clean.observation, still.observation)


def test_the_moving_arm_attenuates_as_the_theorem_says(task, demonstrations):
    """Compliant and overdamped far less deviates from the undisturbed motion than the opposite."""
    rms = {}
    for cell in (Cell(32, 32), Cell(512, 2)):
        table = traces(
            task, demonstrations[0], _control(task, cell), 10, "mean", 0.02,
            np.random.default_rng(0),
        )  # fmt: skip
        joints = [name for name in table.columns if name.startswith("q.")]
        assert len(joints) == len(task.robot.joints)
        steps = len(table) // (1 + TRACES)
        positions = table[joints].to_numpy().reshape(1 + TRACES, steps, -1)
        assert (table.condition == "none").sum() == steps
        assert table.time_s.max() == pytest.approx(0.02 * (steps - 1))
        rms[cell] = np.sqrt(((positions[1:] - positions[0]) ** 2).mean())
    # √(h Kp / (2 Kd)) is 0.1 and 1.6
    assert rms[Cell(512, 2)] > 5 * rms[Cell(32, 32)]
