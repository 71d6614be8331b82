"""Rendered frames of trajectories."""

import logging
from collections.abc import Mapping, Sequence

import matplotlib.pyplot as plt
import mujoco
import numpy as np
from matplotlib.figure import Figure

from t2l.figures import software_renderer
from t2l.figures.style import styled
from t2l.tasks import Task

log = logging.getLogger(__name__)

CAMERA = "overview"
WIDTH, HEIGHT = 480, 400


def render(task: Task, qpos: Sequence[np.ndarray]) -> list[np.ndarray]:
    """An image (height, width, 3) uint8 for every position (nq,); without OpenGL a plainer one."""
    model = task.spec(visual=True).compile()
    data = mujoco.MjData(model)
    renderer = _opengl(model)
    images = []
    for position in qpos:
        data.qpos[:] = position
        mujoco.mj_forward(model, data)
        if renderer is None:
            images.append(software_renderer.render(model, data, CAMERA, WIDTH, HEIGHT))
        else:
            renderer.update_scene(data, CAMERA)
            images.append(renderer.render())
    if renderer is not None:
        renderer.close()
    return images


def _opengl(model: mujoco.MjModel) -> mujoco.Renderer | None:
    try:
        return mujoco.Renderer(model, HEIGHT, WIDTH)
    except (mujoco.FatalError, RuntimeError, ImportError) as error:
        # MuJoCo chooses the platform when it is imported: no other one can be tried from here
        log.warning(
            "no OpenGL here (%s): frames are drawn without it; MUJOCO_GL=egl may bring it", error
        )
        return None


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
