"""What each way of learning reaches under which gains: one panel each (the study's figure 1)."""

from typing import TYPE_CHECKING

import matplotlib.pyplot as plt
from matplotlib.colors import Normalize
from matplotlib.figure import Figure

from t2l.gains import Grid
from t2l.plotting.heatmap import error_norm, heatmap, height, matrix, width
from t2l.plotting.style import styled

if TYPE_CHECKING:
    import pandas as pd


CLONING_COLUMNS = ("kp", "kd", "success")
TRANSFER_COLUMNS = ("kp", "kd", "success_sim_100", "trajectory_error")


def regimes(
    cloning: "pd.DataFrame",
    cloning_grid: Grid,
    transfer: "pd.DataFrame",
    transfer_grid: Grid,
) -> Figure:
    """Behaviour cloning, reinforcement learning, and transfer to the robot, over their grids.

    Rows of the same cell, such as training seeds or tasks, are averaged.

    Args:
        cloning: columns `CLONING_COLUMNS`.
        transfer: columns `TRANSFER_COLUMNS`.
    """
    cloned, learned = (
        table.groupby(["kp", "kd"], as_index=False).mean() for table in (cloning, transfer)
    )
    with styled():
        size = 1.5 * max(width(cloning_grid), width(transfer_grid)) / 1.15
        tall = max(height(cloning_grid), height(transfer_grid))
        figure, axes = plt.subplots(1, 3, figsize=(size, tall + 0.2))
        for panel, values, grid, region, label in (
            (axes[0], matrix(cloned, "success", cloning_grid), cloning_grid, "CO", "success [%]"),
            (
                axes[1], matrix(learned, "success_sim_100", transfer_grid), transfer_grid, None,
                "success in its simulator [%]",
            ),
        ):  # fmt: skip
            heatmap(
                *(panel, values, grid, "viridis", Normalize(0, 1)),
                text=lambda v: f"{100 * v:.0f}",
                label=label,
                percent=True,
                region=region,
            )
        error = matrix(learned, "trajectory_error", transfer_grid)
        heatmap(
            *(axes[2], error, transfer_grid, "magma_r", error_norm(error.flat)),
            text="{:.2g}".format,
            label="trajectory error E [rad² + (rad/s)²]",
            region="SO",
        )
        headings = ("behaviour cloning", "reinforcement learning", "simulator to robot")
        notes = (
            "dashed: compliant, overdamped", "no guard, limits not asked for",
            "dashed: stiff, overdamped",
        )  # fmt: skip
        for letter, panel, heading, note in zip("abc", axes, headings, notes, strict=True):
            panel.set_title("", loc="left")
            panel.set_title(f"({letter}) {heading}\n{note}", fontsize=9)
        figure.suptitle("What each way of learning reaches, by gains", fontsize=11)
    return figure
