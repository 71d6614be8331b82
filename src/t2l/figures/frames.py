"""Rendered frames of trajectories."""

import contextlib
import logging
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import matplotlib.pyplot as plt
import mujoco
import numpy as np
from matplotlib.figure import Figure

from t2l.figures import software_renderer
from t2l.plotting.style import styled
from t2l.plotting.style import title as heading
from t2l.tasks import Task

if TYPE_CHECKING:
    import pandas as pd

log = logging.getLogger(__name__)

CAMERA = "overview"
WIDTH, HEIGHT = 480, 400


class Painter:
    """Draws the scene of a task; without OpenGL more plainly.

    Args:
        shadows: cost three quarters of the time where OpenGL runs in software.
    """

    def __init__(self, task: Task, shadows: bool = True):
        self._model = task.spec(visual=True).compile()
        self._data = mujoco.MjData(self._model)
        self._renderer = _opengl(self._model)
        if self._renderer is not None:
            self._renderer.scene.flags[mujoco.mjtRndFlag.mjRND_SHADOW] = shadows

    def draw(self, qpos: np.ndarray) -> np.ndarray:
        """An image (height, width, 3) uint8 of the scene at a position (nq,)."""
        self._data.qpos[:] = qpos
        mujoco.mj_forward(self._model, self._data)
        if self._renderer is None:
            return software_renderer.render(self._model, self._data, CAMERA, WIDTH, HEIGHT)
        self._renderer.update_scene(self._data, CAMERA)
        return self._renderer.render()

    def close(self) -> None:
        """Release what draws."""
        if self._renderer is not None:
            self._renderer.close()


def render(task: Task, qpos: Sequence[np.ndarray]) -> list[np.ndarray]:
    """An image for every position (nq,), as `Painter.draw` makes it."""
    with contextlib.closing(Painter(task)) as painter:
        return [painter.draw(position) for position in qpos]


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


def learned_frames(task: Task, episodes: "pd.DataFrame", name: str) -> Figure:
    """A success and a failure of a policy, as far as it has them.

    Args:
        episodes: one row a step, columns success, time_s and qpos.
        name: of the task, as a configuration has it.
    """
    strips = {
        "success" if success else "failure": (rows.time_s.to_numpy(), list(rows.qpos))
        for success, rows in episodes.groupby("success", sort=False)
    }
    return filmstrips(task, strips, 6, f"{heading(name)}: {task.instruction}")
