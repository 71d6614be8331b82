import numpy as np
import pytest

from t2l.figures.identification import over_true as draw
from t2l.gains import Cell
from t2l.stats.identification import COLUMNS, over_true, printable

TRUTH = {
    "armature": np.array([0.2, 0.1]), "sliding_friction": np.array([1.0, 0.0]),
    "breakaway": np.array([1.3, 0.0]), "viscous_friction": np.array([0.5, 0.5]),
    "torque_scale": np.ones(2),
}  # fmt: skip


def found(kp, kd, factor=1.0):
    return {
        "stiffness": factor * np.array([kp, kp]), "damping": factor * np.array([kd, kd]),
        "armature": np.array([0.1, 0.1]), "static_friction": np.array([1.3, 0.2]),
        "dynamic_friction_ratio": np.array([0.5, 1.0]), "viscous_friction": np.array([1.0, 0.25]),
    }  # fmt: skip


def test_identified_over_true_by_hand():
    table = over_true(
        {Cell(16, 2): found(16, 2), Cell(64, 8): found(64, 8, 2.0)}, TRUTH, ["a", "b"]
    )
    assert tuple(table.columns) == COLUMNS
    ratio = table.set_index(["kp", "parameter", "joint"]).ratio
    assert ratio[16, "Kp", "a"] == 1
    assert ratio[64, "Kd", "b"] == 2
    assert ratio[16, "armature", "a"] == 0.5
    # 1.3 N·m at rest, half of it in motion
    assert ratio[16, "sliding friction", "a"] == pytest.approx(0.65)
    assert ratio[16, "breakaway", "a"] == 1
    assert np.isnan(ratio[16, "breakaway", "b"])
    printed = printable(table).set_index("joint")
    assert printed.loc["a", "Kp"] == "1.50 (1.00 to 2.00)"
    assert printed.loc["a", "armature"] == "0.50"
    assert printed.loc["b", "sliding friction"] == "true is 0"
    # a map for each parameter and joint, and their bar
    assert len(draw(table).axes) == table.parameter.nunique() * table.joint.nunique() + 1
