import pandas as pd

from t2l.gains import Cell
from t2l.study.landscape.existence import (
    COLUMNS,
    at_corners,
    existence_table,
    printable_existence,
)
from t2l.study.landscape.figures import existence

FR3 = [Cell(kp, kd) for kp in (16, 512) for kd in (2, 24)]
FACTORS = [Cell(kp, kd) for kp in (0.25, 4) for kd in (0.25, 4)]
CELLS = {"lift_cube": FR3, "track_velocity": FACTORS, "pose_hold": FR3[:3]}


def policies():
    rows = [("lift_cube", cell, 500, 495 if cell.kp == 512 else 494) for cell in FR3]
    rows += [("track_velocity", FACTORS[3], 500, 500), ("pose_hold", FR3[0], 100, 100)]
    # two policies of a corner are judged together
    rows += [("lift_cube", FR3[0], 500, 500)]
    table = pd.DataFrame(rows, columns=["task", "cell", "episodes", "successes"])
    kp, kd = ([getattr(cell, gain) for cell in table.cell] for gain in ("kp", "kd"))
    return table.assign(kp=kp, kd=kd)


def test_a_policy_exists_where_99_percent_of_all_episodes_of_a_corner_succeed():
    found = at_corners(policies(), CELLS)
    assert {*COLUMNS} <= {*found.columns}
    # three cells are no corners
    assert "pose_hold" not in set(found.task)
    table = existence_table(found)
    assert table.task.tolist() == ["lift_cube"] * 4 + ["track_velocity"]
    assert table.region.tolist() == ["CO", "CU", "SO", "SU", "SO"]
    assert table.exists.tolist() == [False, True, True, True, True]
    assert table.episodes.tolist() == [500, 1000, 500, 500, 500]
    assert (table.low < table.success).all()
    assert (table.success <= table.high).all()
    # a factor of 4 is the stiffest of these cells
    assert table.published_passed.tolist() == [9, 10, 15, 10, 14]


def test_table_and_figure_tell_what_was_not_run():
    table = existence_table(at_corners(policies(), CELLS))
    lift, walk = printable_existence(table).to_dict("records")
    assert lift["CU"] == "99.4 % (98.7 to 99.7)"
    assert (lift["Policies"], lift["Exists"]) == ("1, 2, 1, 1", "CU, SO, SU")
    assert (walk["CO"], walk["Trials of the study"]) == ("not run", "SO 14 of 50")
    figure = existence(table)
    shown = [text.get_text() for text in figure.axes[0].texts]
    assert shown[1] == "99.4 %\n10 of 50 trials"
    assert len(shown) == 5
    frames = [patch for patch in figure.axes[0].patches if not patch.get_fill()]
    assert len(frames) == 4
