import pandas as pd

from t2l.gains import Grid
from t2l.study.landscape.figures import sample_efficiency

GRID = Grid(kp=(16, 512), kd=(2, 24), compliant_up_to_kp=128, overdamped_from_kd=8)


def test_bands_are_over_configurations_and_seeds():
    curves = pd.DataFrame(
        [(c, s, 1e6, r, 0.5, 16, 24) for (c, s), r in {(1, 1): 1, (1, 2): 3, (4, 1): 5}.items()],
        columns=["configuration", "seed", "steps", "reward", "success", "kp", "kd"],
    )
    figure = sample_efficiency(curves, GRID)
    assert figure.axes[0].lines[0].get_ydata().tolist() == [3]
    assert "3 runs of 2 configurations" in figure.axes[0].lines[0].get_label()
