"""Figures of attenuation are drawn from tables as their stages write them."""

import numpy as np
import pandas as pd
import pytest
from matplotlib.image import imread

from t2l.gains import Grid
from t2l.plotting.style import write
from t2l.study.attenuation import figures
from t2l.study.attenuation.rack import COLUMNS
from t2l.study.attenuation.statistics import effective_error_table
from t2l.study.attenuation.success import predictors

GRID = Grid(kp=(32, 512), kd=(2, 32), compliant_up_to_kp=128, overdamped_from_kd=32)


def _cells(**columns):
    kp, kd = zip(*((cell.kp, cell.kd) for cell in GRID.cells), strict=True)
    return pd.DataFrame({"kp": kp, "kd": kd, **columns})


def _held():
    rows = [
        (
            plant,
            0.1,
            c.kp,
            c.kd,
            0.02,
            0.1,
            8,
            x * 0.009,
            x * 0.001,
            x * 0.01,
            x * 0.0095,
            x * 0.0098,
        )
        for plant in ("joint of 0.1 kg·m²", "joint_7")
        for c in GRID.cells
        for x in [0.01 * c.kp / c.kd]
    ]
    return pd.DataFrame(rows, columns=list(COLUMNS))


def test_the_theorem_is_the_diagonal_and_the_ratio_one():
    figure = figures.variance(_held(), GRID)
    left, right = figure.axes
    assert left.get_xscale() == left.get_yscale() == "log"
    points = np.concatenate([c[0].get_xydata() for c in right.containers])
    np.testing.assert_allclose(points[:, 1], 0.9)
    assert sorted(set(points[:, 0].round(6))) == [0.01, 0.16, 2.56]


def test_success_is_drawn_over_each_predictor_with_its_correlation():
    cells = _cells(success=[0.2, 0.1, 0.9, 0.4], loss=[0.02, 0.01, 0.04, 0.03], seeds=1)
    table = effective_error_table({"block_stack": cells}, 0.02)
    figure = figures.success({"block_stack": predictors(cells, 0.02)}, table, GRID)
    titles = [axes.get_title(loc="right") for axes in figure.axes]
    # the order of success is that of the loss
    assert titles[1] == "ρ +1.00 (too few cells)"
    assert len(titles) == 3


def _replays():
    parts = [
        _cells(success=cells, condition=condition, magnitude_rad=0.03)
        for condition in ("same", "own")
        for cells in ([True, False, True, False], [True, False, True, True])
    ]
    return pd.concat(parts, ignore_index=True)


def test_heatmaps_of_success_under_noise():
    undisturbed = _cells(replay_success=1.0, success=0.5)
    figure = figures.noise_success(_replays(), undisturbed, GRID, "Block Stack")
    without, same, _, _ = figure.axes
    np.testing.assert_allclose(without.images[0].get_array(), 1.0)
    np.testing.assert_allclose(same.images[0].get_array(), [[1, 0], [1, 0.5]])
    assert same.get_title(loc="left").startswith("up to 30 mrad in every cell\n")


@pytest.mark.parametrize("joints", [["elbow"], ["base", "elbow"]])
def test_traces_under_noise(tmp_path, joints):
    time = np.arange(20) / 50
    table = pd.concat(
        [
            pd.DataFrame({"condition": "same" if i else "none", "replay": i, "time_s": time})
            .assign(**{f"q.{joint}": np.sin(time) + 0.1 * i for joint in joints})
            for i in range(3)
        ]
    )  # fmt: skip
    shown = {joint: f"q.{joint}" for joint in joints}
    traces = dict.fromkeys(GRID.opposites, table)
    path = tmp_path / "traces.png"
    figure = figures.noise_traces(traces, shown, GRID, "Block Stack")
    assert [axes.get_title() for axes in figure.axes[:2]] == [
        "CO: Kp 32, Kd 32",
        "SU: Kp 512, Kd 2",
    ]
    write(figure, [path])
    assert imread(path)[..., :3].std() > 0.02
