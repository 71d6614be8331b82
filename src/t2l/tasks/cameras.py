"""What cameras of a scene see, rendered off screen."""

from collections.abc import Sequence
from typing import Self

import mujoco
import numpy as np

from t2l.errors import CameraError, RendererError
from t2l.robots.geometry import fewer

# of all meshes: an arm of 200 000 takes most of the time, and is some dozen pixels wide
MOST_TRIANGLES = 10_000
LEAST_TRIANGLES = 50  # of a mesh, so that a small one keeps its shape

# a renderer without a GPU spends nine tenths of its time on them, and on smooth edges
_LEFT_OUT = (mujoco.mjtRndFlag.mjRND_SHADOW, mujoco.mjtRndFlag.mjRND_REFLECTION)


class Cameras:
    """Some cameras of a model, which are asked again and again.

    The same positions give the same bytes, whatever was rendered before, on the same machine.

    Args:
        model: with all that is to be seen. It is made lighter to render.
        cameras: names of its cameras.
        size_px: width and height of their square pictures.

    Raises:
        CameraError: the model has no such camera.
        RendererError: nothing here can render.
    """

    def __init__(self, model: mujoco.MjModel, cameras: Sequence[str], size_px: int):
        check_cameras(camera_names(model), cameras)
        self.names, self.size_px = tuple(cameras), size_px
        self._model, self._data = model, mujoco.MjData(model)
        lighten(model)
        model.vis.global_.offwidth = model.vis.global_.offheight = size_px
        model.vis.quality.offsamples = 0
        try:
            self._renderer = mujoco.Renderer(model, size_px, size_px)
        except (mujoco.FatalError, RuntimeError, ImportError) as error:
            raise RendererError(
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


def check_cameras(known: Sequence[str], cameras: Sequence[str]) -> None:
    """That cameras are among those that a model has.

    Raises:
        CameraError: one is not.
    """
    for name in cameras:
        if name not in known:
            raise CameraError(f"camera: found {name!r}; allowed: {', '.join(known) or 'none'}")


def camera_names(model: mujoco.MjModel) -> list[str]:
    """Of a model's cameras that have a name."""
    return [name for i in range(model.ncam) if (name := model.camera(i).name)]


def lighten(model: mujoco.MjModel) -> None:
    """Merge corners of meshes, in place, that a small picture does not show; collisions stay."""
    share = MOST_TRIANGLES / max(1, model.mesh_facenum.sum())
    if share >= 1:
        return
    for i in range(model.nmesh):
        corners = slice(model.mesh_vertadr[i], model.mesh_vertadr[i] + model.mesh_vertnum[i])
        first = model.mesh_faceadr[i]
        whole = slice(first, first + model.mesh_facenum[i])
        # a compiled mesh keeps its place in memory, of which the lighter one takes a part
        vertices, faces = fewer(
            model.mesh_vert[corners].astype(float),
            model.mesh_face[whole],
            max(LEAST_TRIANGLES, int(share * model.mesh_facenum[i])),
        )
        if not 0 < len(vertices) <= model.mesh_normalnum[i]:
            continue
        normals = np.zeros_like(vertices)
        a, b, c = vertices[faces].transpose(1, 0, 2)
        for corner in faces.T:
            np.add.at(normals, corner, np.cross(b - a, c - a))
        normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-12)
        model.mesh_vert[corners.start : corners.start + len(vertices)] = vertices
        at = model.mesh_normaladr[i]
        model.mesh_normal[at : at + len(vertices)] = normals
        model.mesh_face[first : first + len(faces)] = faces
        model.mesh_facenormal[first : first + len(faces)] = faces
        model.mesh_facenum[i] = len(faces)
