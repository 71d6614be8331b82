"""Figures of the second chain are drawn from tables as their stages write them."""

import numpy as np
import pandas as pd
import pytest

from t2l.figures import ablation, learning, transfer
from t2l.gains import Cell, Grid
from t2l.plotting.style import write

JOINTS = ("base", "shoulder", "elbow", "arm_roll", "arm_pitch")
GRID = Grid(kp=(16, 512), kd=(1, 24), compliant_up_to_kp=128, overdamped_from_kd=8)


def cells(**changes):
    values = {
        "trajectory_error": [0.1, 2.0, 0.01, 0.5], "nn_error": [0.1, 0.2, 0.05, 0.3],
        "jitter_rate": [0.0, 0.5, 1.0, 0.2], "stopped_rate": 0.0,
        "feedback_gain": [1.0, 2.0, 0.3, 5.0],
    } | changes  # fmt: skip
    kp, kd = zip(*((cell.kp, cell.kd) for cell in GRID.cells), strict=True)
    return pd.DataFrame({"kp": kp, "kd": kd, **values})


def trace():
    time = np.arange(50) / 100
    parts = [
        pd.DataFrame({"rollout": 0, "where": where, "time": time})
        .assign(**{f"dq.{joint}": np.sin(9 * time + shift) for joint in JOINTS})
        for shift, where in enumerate(("real", "sim"))
    ]  # fmt: skip
    return pd.concat(parts)


def seen():
    draw = np.random.default_rng(0)
    names = [f"{signal}.{joint}" for signal in ("q", "dq", "error", "action") for joint in JOINTS]
    table = pd.DataFrame({name: draw.normal(size=80) for name in names})
    return table.assign(rollout=0, where=["real", "sim"] * 40)


def curves(empty=False):
    rows = [
        (steps, -1 / steps, 0.5, cell.kp, cell.kd, seed)
        for cell in GRID.corners for seed in (1, 2) for steps in (1e5, 2e5)
    ]  # fmt: skip
    return pd.DataFrame([] if empty else rows, columns=list(learning.CURVE_COLUMNS))


def trials(state="complete"):
    return pd.DataFrame(
        {
            "state": state, "success": [0.2, 0.9], "action_scale_proximal": [0.1, 0.2],
            "action_scale_distal": [0.01, 0.02], "kp": 16.0, "kd": 1.0,
        }
    )  # fmt: skip


CELL = Cell(16, 1)
ABLATED = pd.DataFrame(
    [
        (effect, kp, kd, rate)
        for effect, rate in (("whole robot", 0.9), ("policy_latency", 0.2))
        for kp, kd in ((16, 1), (512, 24))
    ],
    columns=["effect", "kp", "kd", "jitter_rate"],
)
JITTER = pd.DataFrame(
    {
        "period_s": [0.01, 0.02], "jitter_rate": [0.1, 0.0], "jitter_rate_sim": [0.0, 0.0],
        "lower": [0.0, 0.0], "upper": [0.3, 0.1], "rollouts": [30, 30], "stopped_rate": [0.1, 0.0],
        "cells": [3, 3],
    }
)  # fmt: skip


@pytest.mark.parametrize(
    "figure",
    [
        lambda: transfer.error_maps({"a": cells(), "b": cells()}, GRID),
        lambda: transfer.error_maps({"a": cells(trajectory_error=np.nan)}, GRID),
        lambda: transfer.jitter_by_period(JITTER),
        lambda: transfer.wrist_trajectories({CELL: trace()}, ["least error"]),
        lambda: transfer.observation_distributions({CELL: seen()}),
        lambda: learning.landscape({CELL: trials(), Cell(512, 1): trials("pruned")}, GRID),
        lambda: ablation.ablation(ABLATED, {Cell(16, 1): False, Cell(512, 24): True}),
        lambda: learning.training_curves({"a": curves(), "b": curves(empty=True)}, GRID),
    ],
    ids=[
        "errors",
        "no errors",
        "jitter",
        "wrist",
        "observations",
        "landscape",
        "ablation",
        "curves",
    ],
)
def test_a_figure_is_written(figure, tmp_path):
    path = tmp_path / "figure.png"
    write(figure(), [path])
    assert path.stat().st_size > 10_000


def test_where_nothing_was_searched_the_figure_says_so():
    (panel,) = learning.landscape({}, GRID).axes
    assert panel.texts[0].get_text() == "no trials: the action scales are given"


@pytest.mark.parametrize("joints", [("one",), ("one", "two"), JOINTS], ids=len)
def test_an_arm_has_as_many_joints_as_its_tables_say(joints):
    trace_of = trace()[["rollout", "where", "time", *(f"dq.{j}" for j in JOINTS[: len(joints)])]]
    seen_of = seen()[
        [c for c in seen().columns if c.partition(".")[2] in ("", *JOINTS[: len(joints)])]
    ]
    figure = transfer.wrist_trajectories({CELL: trace_of}, ["least error"])
    drawn = [panel.get_ylabel().partition("\n")[0] for panel in figure.axes]
    own = JOINTS[: len(joints)]
    assert drawn == list(own[-3:])
    figure = transfer.observation_distributions({CELL: seen_of})
    drawn = {panel.get_xlabel().partition(" ")[0] for panel in figure.axes}
    ends = {own[:2][-1], own[-2:][0]}
    assert drawn >= {f"{signal}.{joint}" for signal in ("q", "dq") for joint in ends}
