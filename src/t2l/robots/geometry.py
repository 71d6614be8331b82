"""The shapes of a robot's bodies as triangles, few enough to travel in a page."""

from dataclasses import dataclass

import mujoco
import numpy as np

MOST_TRIANGLES = 20_000  # of all bodies together: 0.3 MB in a page
DRAWN_GROUPS = 2  # MuJoCo's own viewer shows groups up to this at first
ROUND = 16  # corners of a circle
STICK = 0.03  # thickness of a body without shapes, of the robot's extent
FINEST = 4.0  # cells along the longest side of a mesh, over the root of its triangles
_BOX = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], float)
_BOX_FACES = np.array(
    [
        *([0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1]),
        *([2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4], [1, 5, 7], [1, 7, 3]),
    ]
)
Triangles = tuple[np.ndarray, np.ndarray]


@dataclass(frozen=True)
class Shape:
    """What is drawn of a body.

    Attributes:
        body: index in the model.
        vertices: (n, 3) m, in the frame of the body.
        triangles: (m, 3) indices of vertices.
    """

    body: int
    vertices: np.ndarray
    triangles: np.ndarray


def shapes(model: mujoco.MjModel, most_triangles: int = MOST_TRIANGLES) -> list[Shape]:
    """Every body that has a shape; a moving body without one is drawn as sticks.

    Meshes with more triangles than their share have corners merged that lie in one cell of a grid
    (vertex clustering: Rossignac and Borrel, Multi-resolution 3D approximations, 1993).
    """
    found: dict[int, list[Triangles]] = {}
    for body in range(model.nbody):
        geoms = [g for g in range(model.ngeom) if model.geom_bodyid[g] == body]
        drawn = [g for g in geoms if model.geom_group[g] <= DRAWN_GROUPS] or geoms
        parts = [part for g in drawn if (part := _in_body(model, g)) is not None]
        if not parts and model.body_weldid[body]:
            parts = _sticks(model, body)
        if parts:
            found[body] = parts
    total = sum(len(faces) for parts in found.values() for _, faces in parts)
    share = min(1.0, most_triangles / max(total, 1))
    return [
        Shape(body, *_joined([fewer(*part, int(share * len(part[1]))) for part in parts]))
        for body, parts in found.items()
    ]


def fewer(vertices: np.ndarray, faces: np.ndarray, most: int) -> Triangles:
    """At most `most` triangles, or as few as merging corners leaves."""
    low, size = vertices.min(axis=0), max(np.ptp(vertices, axis=0).max(), 1e-9)
    # a flat side of n × n cells has 2 n² triangles: no finer grid leaves few enough
    cells, found = int(FINEST * np.sqrt(max(most, 1))) + 1, (vertices, faces)
    while len(found[1]) > most and cells > 1:
        place = np.minimum((vertices - low) / size * cells, cells - 1).astype(np.int64)
        _, merged = np.unique(place @ [cells * cells, cells, 1], return_inverse=True)
        count = np.bincount(merged)
        middle = np.stack([np.bincount(merged, column) / count for column in vertices.T], axis=1)
        a, b, c = corners = merged[faces].T
        found = middle, corners.T[(a != b) & (b != c) & (a != c)]
        cells = int(cells / 1.2)
    return found if len(found[1]) <= most else (vertices[:0], faces[:0])


def _in_body(model: mujoco.MjModel, geom: int) -> Triangles | None:
    """A geom's triangles in the frame of its body; None for planes and fields."""
    local = _local(model, geom)
    if local is None:
        return None
    rotation = np.zeros(9)
    mujoco.mju_quat2Mat(rotation, model.geom_quat[geom])
    return local[0] @ rotation.reshape(3, 3).T + model.geom_pos[geom], local[1]


def _local(model: mujoco.MjModel, geom: int) -> Triangles | None:
    kind, size = mujoco.mjtGeom(model.geom_type[geom]), model.geom_size[geom]
    if kind == mujoco.mjtGeom.mjGEOM_BOX:
        return _BOX * size, _BOX_FACES
    if kind == mujoco.mjtGeom.mjGEOM_MESH:
        mesh = model.mesh(model.geom_dataid[geom])
        first, face = mesh.vertadr[0], mesh.faceadr[0]
        vertices = model.mesh_vert[first : first + mesh.vertnum[0]].astype(float)
        return vertices, model.mesh_face[face : face + mesh.facenum[0]]
    if kind == mujoco.mjtGeom.mjGEOM_SPHERE:
        return round_shape(size[0], size[0], 0.0)
    if kind == mujoco.mjtGeom.mjGEOM_ELLIPSOID:
        vertices, faces = round_shape(1.0, 1.0, 0.0)
        return vertices * size, faces
    if kind == mujoco.mjtGeom.mjGEOM_CAPSULE:
        return round_shape(size[0], size[0], size[1])
    if kind == mujoco.mjtGeom.mjGEOM_CYLINDER:
        return round_shape(size[0], 0.0, size[1])
    return None


def round_shape(radius: float, cap: float, half: float) -> Triangles:
    """A body of revolution about z: caps `cap` high on a cylinder of half a length `half`."""
    angle = np.linspace(-np.pi / 2, np.pi / 2, ROUND + 1)
    turn = np.linspace(0, 2 * np.pi, ROUND, endpoint=False)
    rings = [(0.0, -half - cap)]
    rings += [(radius * np.cos(a), cap * np.sin(a) + np.copysign(half, a)) for a in angle if a < 0]
    rings += [(radius * np.cos(a), cap * np.sin(a) + half) for a in angle if a >= 0]
    if not cap:
        rings = [(0.0, -half), (radius, -half), (radius, half), (0.0, half)]
    grid = np.array([[r * np.cos(t), r * np.sin(t), z] for r, z in rings for t in turn])
    first = (np.arange(len(rings) - 1)[:, None] * ROUND + np.arange(ROUND)).ravel()
    beside = first - first % ROUND + (first + 1) % ROUND
    faces = np.concatenate(
        [
            np.stack([first, beside, first + ROUND], axis=1),
            np.stack([beside, beside + ROUND, first + ROUND], axis=1),
        ]
    )
    return grid, faces


def _sticks(model: mujoco.MjModel, body: int) -> list[Triangles]:
    """From a body's joint to where its mass, its children and its sites are."""
    joint = model.body_jntadr[body]
    origin = model.jnt_pos[joint] if joint >= 0 else np.zeros(3)
    children = [b for b in range(model.nbody) if model.body_parentid[b] == body and b != body]
    sites = [s for s in range(model.nsite) if model.site_bodyid[s] == body]
    ends = [model.body_ipos[body], *model.body_pos[children], *model.site_pos[sites]]
    radius = STICK * max(model.stat.extent, 1e-3) / 2
    return [_stick(origin, end, radius) for end in ends if np.linalg.norm(end - origin) > radius]


def _stick(start: np.ndarray, end: np.ndarray, radius: float) -> Triangles:
    length = np.linalg.norm(end - start)
    vertices, faces = round_shape(radius, radius, length / 2)
    quaternion, rotation = np.zeros(4), np.zeros(9)
    mujoco.mju_quatZ2Vec(quaternion, (end - start) / length)
    mujoco.mju_quat2Mat(rotation, quaternion)
    return vertices @ rotation.reshape(3, 3).T + (start + end) / 2, faces


def _joined(parts: list[Triangles]) -> Triangles:
    first = np.cumsum([0, *(len(vertices) for vertices, _ in parts)])
    faces = [faces + at for (_, faces), at in zip(parts, first, strict=False)]
    return np.concatenate([vertices for vertices, _ in parts]), np.concatenate(faces)
