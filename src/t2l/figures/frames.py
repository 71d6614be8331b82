"""Rendered frames of trajectories."""

from collections.abc import Mapping, Sequence

import matplotlib.pyplot as plt
import mujoco
import numpy as np
from matplotlib.figure import Figure

from t2l.figures.style import styled
from t2l.tasks import Task

CAMERA = "overview"
WIDTH, HEIGHT = 480, 400


def render(task: Task, qpos: Sequence[np.ndarray]) -> list[np.ndarray]:
    """An image (height, width, 3) uint8 for every position (nq,)."""
    model = task.spec(visual=True).compile()
    data = mujoco.MjData(model)
    images = []
    with mujoco.Renderer(model, HEIGHT, WIDTH) as renderer:
        for position in qpos:
            data.qpos[:] = position
            mujoco.mj_forward(model, data)
            renderer.update_scene(data, CAMERA)
            images.append(renderer.render())
    return images


def filmstrips(
    task: Task, trajectories: Mapping[str, tuple[np.ndarray, np.ndarray]], columns: int, title: str
) -> Figure:
    """A row of frames, evenly spaced in time, for every trajectory.

    Args:
        trajectories: per label, times (n,) s and positions (n, nq).
    """
    picked = {
        label: np.linspace(0, len(times) - 1, columns).round().astype(int)
        for label, (times, _) in trajectories.items()
    }
    images = iter(
        render(task, [trajectories[label][1][i] for label, index in picked.items() for i in index])
    )
    with styled():
        figure, axes = plt.subplots(
            *(len(trajectories), columns),
            figsize=(1.75 * columns, 1.62 * len(trajectories) + 0.4),
            squeeze=False,
        )
        for row, (label, (times, _)) in zip(axes, trajectories.items(), strict=True):
            for panel, i in zip(row, picked[label], strict=True):
                panel.imshow(next(images))
                panel.set_xticks([])
                panel.set_yticks([])
                panel.spines[:].set_visible(False)
                panel.set_title(f"{times[i]:.1f} s", fontsize=8, pad=2)
            row[0].set_ylabel(label, fontsize=8)
        figure.suptitle(title, fontsize=11)
    return figure
