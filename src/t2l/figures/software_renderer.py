"""Pictures of a scene without OpenGL, for machines that have none.

Triangles of boxes, planes and meshes, shaded by one light and painted from far to near (Newell,
Newell and Sancha 1972 without their splitting): plain, and good enough to see what happens.
"""

import mujoco
import numpy as np
from PIL import Image, ImageDraw

BACKGROUND = (237, 241, 245)
_LIGHT = np.array([0.35, -0.45, 0.82])
_OVERSAMPLING = 2
_PLANE_TILES = 20
_BOX_CORNERS = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], float)
_BOX_FACES = np.array(
    [
        *([0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1]),
        *([2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4], [1, 5, 7], [1, 7, 3]),
    ]
)


def render(
    model: mujoco.MjModel, data: mujoco.MjData, camera: str, width: int, height: int
) -> np.ndarray:
    """The view of a named camera, (height, width, 3) uint8; `data` has its kinematics current."""
    triangles, colours, floor = _triangles(model, data)
    view = data.camera(camera)
    seen = (triangles - view.xpos) @ view.xmat.reshape(3, 3)
    normals = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    length = np.linalg.norm(normals, axis=1)
    towards = np.einsum("ij,ij->i", normals, view.xpos - triangles[:, 0]) > 0
    visible = towards & (length > 0) & (seen[:, :, 2] < -0.05).all(axis=1)
    shade = 0.55 + 0.45 * np.clip(normals[visible] @ _LIGHT / length[visible], 0, 1)
    rgb = (255 * np.clip(colours[visible] * shade[:, None], 0, 1)).astype(np.uint8)

    scale = _OVERSAMPLING * height / (2 * np.tan(np.radians(model.camera(camera).fovy[0]) / 2))
    depth = -seen[visible][:, :, 2]
    x = _OVERSAMPLING * width / 2 + scale * seen[visible][:, :, 0] / depth
    y = _OVERSAMPLING * height / 2 - scale * seen[visible][:, :, 1] / depth
    corners = np.stack([x, y], axis=-1).reshape(len(x), 6)

    image = Image.new("RGB", (_OVERSAMPLING * width, _OVERSAMPLING * height), BACKGROUND)
    pen = ImageDraw.Draw(image)
    # the floor first: nothing is below it
    for i in np.lexsort((-depth.mean(axis=1), ~floor[visible])):
        pen.polygon(corners[i].tolist(), fill=tuple(rgb[i].tolist()))
    return np.asarray(image.resize((width, height), Image.Resampling.LANCZOS))


def _triangles(
    model: mujoco.MjModel, data: mujoco.MjData
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """World corners (n, 3, 3), colours (n, 3) and whether of a plane (n,), of what is shown."""
    parts, colours, planes = [], [], []
    for geom in range(model.ngeom):
        local = _local_triangles(model, geom) if model.geom_group[geom] <= 2 else None
        if local is None:
            continue
        rotation = data.geom_xmat[geom].reshape(3, 3)
        parts.append(local @ rotation.T + data.geom_xpos[geom])
        material = model.geom_matid[geom]
        rgba = model.mat_rgba[material] if material >= 0 else model.geom_rgba[geom]
        colours.append(np.tile(rgba[:3], (len(local), 1)))
        planes.append(np.full(len(local), model.geom_type[geom] == mujoco.mjtGeom.mjGEOM_PLANE))
    return np.concatenate(parts), np.concatenate(colours), np.concatenate(planes)


def _local_triangles(model: mujoco.MjModel, geom: int) -> np.ndarray | None:
    kind, size = model.geom_type[geom], model.geom_size[geom]
    if kind == mujoco.mjtGeom.mjGEOM_BOX:
        return (_BOX_CORNERS * size)[_BOX_FACES]
    if kind == mujoco.mjtGeom.mjGEOM_PLANE:
        # tiles: what reaches behind the camera is left out
        edge = np.linspace(-1, 1, _PLANE_TILES + 1)
        x, y = np.meshgrid(edge * size[0], edge * size[1], indexing="ij")
        grid = np.stack([x, y, np.zeros_like(x)], axis=-1)
        a, b, c, d = grid[:-1, :-1], grid[1:, :-1], grid[1:, 1:], grid[:-1, 1:]
        halves = [np.stack(corners, axis=2) for corners in ((a, b, c), (a, c, d))]
        return np.concatenate(halves).reshape(-1, 3, 3)
    if kind == mujoco.mjtGeom.mjGEOM_MESH:
        mesh = model.mesh(model.geom_dataid[geom])
        first, count = mesh.vertadr[0], mesh.vertnum[0]
        vertices = model.mesh_vert[first : first + count]
        faces = model.mesh_face[mesh.faceadr[0] : mesh.faceadr[0] + mesh.facenum[0]]
        return vertices[faces].astype(float)
    return None
