import numpy as np
import pytest

from t2l.figures.responses import responses
from t2l.gains import Cell, Grid
from t2l.hardware import open_backend
from t2l.hardware.steps import COLUMNS, STEP_RAD, step_responses
from t2l.robots import make_robot

GRID = Grid(kp=(16, 512), kd=(2, 24), compliant_up_to_kp=128, overdamped_from_kd=8)


def test_an_overdamped_stiff_arm_settles_where_it_is_stepped_to():
    with open_backend({"backend": "virtual"}, make_robot("fr3")) as arm:
        table = step_responses(arm, GRID.cells[-1])
    assert tuple(table.columns) == COLUMNS
    assert list(dict.fromkeys(table.joint)) == ["fr3_joint4", "fr3_joint7"]
    before, after = table[table.time < -0.005], table[table.time > 1.5]
    assert (before.q_des == 0).all()
    np.testing.assert_allclose(before.q, 0, atol=2e-3)
    np.testing.assert_allclose(after.q_des, STEP_RAD)
    np.testing.assert_allclose(after.q, STEP_RAD, atol=5e-3)
    figure = responses({"step": {cell: table for cell in GRID.corners}}, GRID)
    assert [axes.get_title() for axes in figure.axes[:4]] == [
        f"{GRID.region(cell)}: {cell}" for cell in GRID.corners
    ]


def test_a_step_that_makes_a_joint_too_fast_is_made_smaller():
    robot = make_robot("fr3")
    with open_backend({"backend": "virtual"}, robot) as arm:
        table = step_responses(arm, Cell(512, 1))
    elbow, last = (part.q_des.max() for _, part in table.groupby("joint"))
    assert elbow == pytest.approx(STEP_RAD)
    assert last == pytest.approx(STEP_RAD / 4)
