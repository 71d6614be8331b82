import pandas as pd

from t2l.study.decoupling.figures import stiffness_at_the_end, stiffness_over_training


def seed(*stiffness, drift=0.0, success=1.0, update=10):
    return pd.DataFrame(
        {
            "update": update, "stiffness_n_m": stiffness, "passive_n_m": 30.0,
            "drift": drift, "success": success,
        }
    )  # fmt: skip


def test_stiffness_is_the_median_over_directions_and_seeds():
    figure = stiffness_over_training({"soft_arm": {1: seed(100, 200, 900), 2: seed(150, 250)}})
    assert figure.axes[0].lines[0].get_ydata().tolist() == [200]
    assert figure.axes[0].get_title().endswith("2 seeds")


def test_a_dot_says_where_the_course_is_one_of_stiffness():
    """Force over displacement of a tool that drifts, or of a pose that is not held, has none."""
    course = [seed(100, drift=1.6), seed(200, success=0.0, update=20), seed(300, update=30)]
    figure = stiffness_over_training({"soft_arm": {1: pd.concat(course)}})
    dots = [
        line for line in figure.axes[0].lines if line.get_marker() == "o" and len(line.get_xdata())
    ]
    assert [line.get_xydata().tolist() for line in dots] == [[[30, 300]]]


def test_what_is_no_stiffness_is_open():
    trainings = pd.DataFrame(
        {
            "pairing": ["soft"] * 2 + ["stiff"] * 2, "kp": [16] * 2 + [512] * 2, "kd": 8,
            "seed": [1, 2, 1, 2], "stiffness_n_m": [900.0, 800.0, 200.0, 300.0],
            "passive_n_m": 30.0, "drift": [0.02, 0.5, 0.02, 0.02], "success": [1.0, 1.0, 1.0, 0.0],
        }
    )  # fmt: skip
    figure = stiffness_at_the_end(trainings)
    filled, still_open = [], []
    for marks in figure.axes[0].collections:
        if hasattr(marks, "get_sizes"):
            into = filled if len(marks.get_facecolor()) else still_open
            into += [y for _, y in marks.get_offsets()]
    assert (filled, still_open) == ([900, 200], [800, 300])
    assert figure.axes[0].get_title() == "2 of 4 policies hold their pose and yield steadily"
