"""What cameras of a scene see, rendered off screen."""

from collections.abc import Sequence
from typing import Self

import mujoco
import numpy as np

from t2l.errors import CameraError

# a renderer without a GPU spends nine tenths of its time on them, and on smooth edges
_LEFT_OUT = (mujoco.mjtRndFlag.mjRND_SHADOW, mujoco.mjtRndFlag.mjRND_REFLECTION)


class Cameras:
    """Some cameras of a model, which are asked again and again.

    The same positions give the same bytes, whatever was rendered before, on the same machine.

    Args:
        model: with all that is to be seen; its own quality of rendering is not regarded.
        cameras: names of its cameras.
        size_px: width and height of their square pictures.

    Raises:
        CameraError: the model has no such camera, or nothing here can render.
    """

    def __init__(self, model: mujoco.MjModel, cameras: Sequence[str], size_px: int):
        known = camera_names(model)
        for name in cameras:
            if name not in known:
                raise CameraError(f"camera: found {name!r}; allowed: {', '.join(known) or 'none'}")
        self.names, self.size_px = tuple(cameras), size_px
        self._model, self._data = model, mujoco.MjData(model)
        model.vis.global_.offwidth = model.vis.global_.offheight = size_px
        model.vis.quality.offsamples = 0
        try:
            self._renderer = mujoco.Renderer(model, size_px, size_px)
        except (mujoco.FatalError, RuntimeError, ImportError) as error:
            raise CameraError(
                f"pictures need OpenGL, which is not here ({error}); MUJOCO_GL=egl may bring it"
            ) from None
        for flag in _LEFT_OUT:
            self._renderer.scene.flags[flag] = False

    @property
    def shape(self) -> tuple[int, int, int, int]:
        """Of one state's pictures: (ncamera, height, width, 3)."""
        return (len(self.names), self.size_px, self.size_px, 3)

    def pictures(self, qpos: np.ndarray) -> np.ndarray:
        """(n, ncamera, height, width, 3) uint8 at positions (n, nq)."""
        seen = np.empty((len(qpos), *self.shape), np.uint8)
        for position, pictures in zip(qpos, seen, strict=True):
            self._data.qpos[:] = position
            mujoco.mj_fwdPosition(self._model, self._data)
            for name, picture in zip(self.names, pictures, strict=True):
                self._renderer.update_scene(self._data, name)
                self._renderer.render(out=picture)
        return seen

    def close(self) -> None:
        """Let go of the renderer."""
        self._renderer.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *exception: object) -> None:
        self.close()


def camera_names(model: mujoco.MjModel) -> list[str]:
    """Of a model's cameras that have a name."""
    return [name for i in range(model.ncam) if (name := model.camera(i).name)]
