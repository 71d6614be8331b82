"""Planted tables come out each way: a trend is found, so is its absence, few cells cannot tell."""

import numpy as np
import pandas as pd

from t2l.stats.rank import spearman
from tests.study.judged import CLAIMS, NO, YES, verdict
from tests.study.planted import CLONING, evidence, frame


def test_the_effective_error():
    path = "block_stack__nominal__cells"
    flat = frame(
        CLONING, "cloning", success=lambda kp, kd, region: 1 / (1 + kp / kd / 16), rollouts=100
    )
    governed = flat.assign(validation_mse_rad2=0.01 + 1e-6 * np.arange(16) ** 2 % 7e-6)
    assert verdict("effective_error", **{path: governed}) is YES
    assert verdict("effective_error", **{path: governed.assign(success=1 - governed.success)}) is NO
    assert verdict("effective_beats_loss", **{path: governed}) is YES
    # a loss that falls with success as much as the effective error does tells as much
    as_good = governed.assign(validation_mse_rad2=governed.kp / governed.kd)
    assert verdict("effective_beats_loss", **{path: as_good}) is not YES
    assert verdict("loss_misleads", **{path: as_good}) is NO


def test_a_loss_that_tells_success_perfectly_is_not_beaten():
    """ρ of success with the loss is +1.00, with the effective error near 0."""
    path, cells = "block_stack__nominal__cells", frame(CLONING, "cloning", success=0, rollouts=100)
    # the loss is what the attenuation takes away, and a little more or less from cell to cell
    effective = 1 + 1e-3 * (np.arange(16) * 7 % 16)
    cells["validation_mse_rad2"] = effective**2 / (cells.kp / (2 * cells.kd))
    cells["success"] = cells.validation_mse_rad2.rank() / 20
    found = CLAIMS["effective_beats_loss"].finding(evidence(**{path: cells}))
    assert found.ours.endswith("+1.00")
    assert abs(spearman(effective, cells.success.to_numpy())) < 0.3
    assert found.verdict is NO


def test_the_effective_error_is_set_beside_the_ratio_of_gains():
    path = "block_stack__nominal__cells"
    cells = frame(CLONING, "cloning", success=0, rollouts=100)
    effective = 1e-3 * (1 + np.arange(16) * 7 % 16)
    cells["validation_mse_rad2"] = effective**2 / (cells.kp / (2 * cells.kd))
    by_error = cells.assign(success=1 - pd.Series(effective).rank() / 20)
    by_ratio = cells.assign(success=(cells.kd / cells.kp).rank() / 20)
    assert verdict("effective_beats_ratio", **{path: by_error}) is YES
    assert verdict("effective_beats_ratio", **{path: by_ratio}) is NO
    # an error that raises success is no support, however strong
    assert verdict("effective_beats_ratio", **{path: by_error.assign(success=effective)}) is NO


def _variances(wrong=0.0, by_mass=0.0):
    rows = []
    for kp, kd in CLONING:
        for mass in (0.1, 1.0):
            held = 0.02 * kp / (2 * kd)
            value = 0.01**2 * held * (1 + wrong + by_mass * np.log10(mass))
            rows.append(("joint", mass, kp, kd, 0.02, 0.01, value))
    columns = ["plant", "inertia_kg_m2", "kp", "kd", "hold_s", "noise_rad", "variance_rad2"]
    return pd.DataFrame(rows, columns=columns)


def test_the_theorem_holds_or_not():
    name = "attenuation__held_noise"
    assert verdict("variance_theorem", **{name: _variances()}) is YES
    assert verdict("variance_theorem", **{name: _variances(wrong=0.2)}) is NO
    assert verdict("variance_mass", **{name: _variances()}) is YES
    assert verdict("variance_mass", **{name: _variances(by_mass=0.2)}) is NO


def test_replays_under_noise():
    def noise(co, stiff):
        share = {"CO": co, "CU": 0.5, "SO": stiff, "SU": stiff}
        table = frame(CLONING, "cloning", success=lambda kp, kd, region: share[region])
        return table.assign(condition="same")

    name = "block_stack__noise__kp32_kd2__noisy_replays"
    assert verdict("noise_robustness", **{name: noise(0.9, 0.0)}) is YES
    assert verdict("noise_robustness", **{name: noise(0.5, 0.5)}) is NO
    assert verdict("noise_stiff_fails", **{name: noise(0.9, 0.0)}) is YES
    assert verdict("noise_stiff_fails", **{name: noise(0.9, 0.4)}) is NO
