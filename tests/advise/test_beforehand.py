"""What is known of a cell before training, on loops and demonstrations whose answer is known."""

import numpy as np
import pandas as pd
import pytest

from t2l.advise.attenuation import attenuation
from t2l.advise.beforehand import (
    PAIRS,
    RESIDUALS,
    forecast,
    matrices,
    residuals,
)

TIMESTEP_S, STEPS = 0.002, 10
INERTIA = np.array([0.5])
NOISE = np.array([0.02, 0.3, 0.1])  # of position, torque and velocity


def demonstrations(rng, noise, count=12, length=300):
    """States that tell (q, τ, q̇) of two joints but for noise."""
    states = [rng.uniform(-1, 1, (length, 1)) for _ in range(count)]
    shape = (length, 2, 3)
    return states, [np.full(shape, 0.1) * s[:, :, None] + noise * rng.normal(size=shape)
                    for s in states]  # fmt: skip


def test_what_states_tell_is_no_residual():
    states, recorded = demonstrations(np.random.default_rng(0), 0 * NOISE)
    assert residuals(states, recorded, ahead=1).max() < 1e-5


def test_noise_is_left_with_that_of_the_mean_of_five():
    states, recorded = demonstrations(np.random.default_rng(0), NOISE)
    c = residuals(states, recorded, ahead=1)
    np.testing.assert_allclose(np.einsum("jcc->jc", c), [1.2 * NOISE**2] * 2, rtol=0.1)


def test_a_position_that_alike_states_do_not_share_is_no_residual_of_displacements():
    rng = np.random.default_rng(0)
    states, recorded = demonstrations(rng, 0 * NOISE)
    for one in recorded:
        one[..., 0] = rng.normal() + 0.01 * np.arange(len(one))[:, None]
    positions, displacements = (
        residuals(states, recorded, ahead=5, displacements=kind)[0, 0, 0] for kind in (False, True)
    )
    assert positions > 0.1
    # but for the last states, whose future stands still
    assert displacements < 1e-4


def test_neighbours_are_of_other_demonstrations():
    with pytest.raises(ValueError, match="1 demonstrations"):
        residuals([np.zeros((9, 1))], [np.zeros((9, 1, 3))], ahead=1)


def test_difficulty_is_that_of_the_commands_themselves():
    states, recorded = demonstrations(np.random.default_rng(1), NOISE)
    kp, kd = 64.0, 8.0
    commands = [one @ np.array([1, 1 / kp, kd / kp]) for one in recorded]
    # the same commands as positions without torque and velocity
    alone = [np.stack([one, 0 * one, 0 * one], axis=-1) for one in commands]
    of_commands = residuals(states, alone, ahead=3)[:, 0, 0].mean()
    c = residuals(states, recorded, ahead=3)
    told = forecast(kp, kd, np.full(2, 0.5), c, TIMESTEP_S, STEPS)
    assert told["label_difficulty"] == pytest.approx(of_commands, rel=1e-9)


def test_amplification_is_that_of_the_theorem_and_makes_the_predicted_error():
    c = np.zeros((1, 3, 3))
    c[0, 0, 0] = 0.01
    told = forecast(32, 16, INERTIA, c, TIMESTEP_S, STEPS)
    theorem = attenuation(32, 16, TIMESTEP_S * STEPS)
    assert told["amplification"] == pytest.approx(theorem, rel=0.05)
    assert told["predicted_error"] == pytest.approx(0.1 * np.sqrt(told["amplification"]))


def test_a_stiff_loop_goes_further_in_a_hold_and_a_damped_one_settles_more_slowly():
    c = np.zeros((1, 3, 3))
    soft, stiff, damped = (
        forecast(kp, kd, INERTIA, c, TIMESTEP_S, STEPS)
        for kp, kd in ((64, 16), (512, 16), (64, 64))
    )
    assert stiff["injection"] > 4 * soft["injection"]
    assert 1 > damped["contraction"] > soft["contraction"]


def test_a_kept_table_gives_the_matrices_back():
    c = np.random.default_rng(0).normal(size=(2, 3, 3))
    c += c.transpose(0, 2, 1)
    kept = pd.DataFrame({name: c[:, i, k] for name, (i, k) in zip(RESIDUALS, PAIRS, strict=True)})
    np.testing.assert_array_equal(matrices(kept), c)
