import matplotlib.pyplot as plt
import numpy as np

from t2l.gains import Grid
from t2l.plotting.heatmap import error_norm, heatmap


def test_small_differences_of_errors_have_similar_colours():
    # told apart only against the noise: both are near it
    norm = error_norm([2e-4, 6e-4], floor=2e-4)
    assert norm(2e-4) == 0
    assert norm(6e-4) < 0.5
    # without a known floor the scale spans a decade, and more where errors do
    norm = error_norm([5.0, 6.0, np.nan])
    assert norm(6.0) - norm(5.0) < 0.1
    assert error_norm([1.0, 1000.0])(1.0) == 0
    assert error_norm([1.0, 1000.0])(1000.0) == 1


def test_a_single_cell_is_a_number_and_no_map():
    grid = Grid(kp=(32,), kd=(2,), compliant_up_to_kp=128, overdamped_from_kd=32)
    figure, axes = plt.subplots()
    norm = error_norm([0.25])
    heatmap(axes, np.array([[0.25]]), grid, "magma_r", norm, "{:.2f}".format, "loss")
    assert not axes.images
    assert axes.texts[0].get_text() == "loss\n0.25\nat Kp 32, Kd 2"
    plt.close(figure)
