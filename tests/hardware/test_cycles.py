import numpy as np

from t2l.hardware.cycles import Cycles, rows_of_commands


def test_rows_are_kept_where_commands_change_and_while_they_hold():
    q_des = np.array([0, 0, 1, 1, 1, 2, 2, 2, 2, 2, 2, 2, 2, 3.0])[:, None]
    assert rows_of_commands(q_des, period=3).tolist() == [0, 2, 5, 8, 11, 13]


def test_time_is_from_the_first_row_that_is_kept():
    log = Cycles(7 + np.arange(5) / 1000, np.arange(5.0)[:, None], {"q": np.ones((5, 1))})
    kept = log.at(np.array([2, 4]))
    assert kept.time.tolist() == [0, 0.002]
    assert kept.q_des[:, 0].tolist() == [2, 4]
    assert kept.measured["q"].shape == (2, 1)
