import pandas as pd

from t2l.study.decoupling.figures import stiffness_over_training


def test_stiffness_is_the_median_over_directions_and_seeds():
    def seed(*stiffness):
        return pd.DataFrame({"update": 10, "stiffness_n_m": stiffness, "passive_n_m": 30.0})

    figure = stiffness_over_training({"soft_arm": {1: seed(100, 200, 900), 2: seed(150, 250)}})
    assert figure.axes[0].lines[0].get_ydata().tolist() == [200]
    assert figure.axes[0].get_title().endswith("2 seeds")
