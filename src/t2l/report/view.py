"""The measured and the simulated robot in three dimensions: shapes, poses and errors as numbers."""

import base64
from typing import Any

import mujoco
import numpy as np

from t2l.diagnose.results import Compared, Found
from t2l.errors import T2LError
from t2l.report.payload import recordings_to_show
from t2l.robots import plant
from t2l.robots.geometry import MOST_TRIANGLES, shapes

FASTEST_HZ = 25.0  # poses: motion looks smooth
SLOWEST_HZ = 5.0  # rather than slower, recordings are left out
MOST_POSES = 60_000  # of single bodies: 1.1 MB in a page
COLOURED = 99.0  # percentile of the errors at which the colours end: one spike must not hide all
FULL = 32767  # of an int16
LIMITS = {"triangles": MOST_TRIANGLES, "fastest_hz": FASTEST_HZ}


def view(found: Found) -> dict[str, Any] | None:
    """Everything that the page's viewer draws; None where the robot cannot be loaded any more."""
    first = found.compared[0]
    model = _model(first)
    if model is None or not set(first.traces.joints) <= _joints(model):
        return None
    drawn = shapes(model)
    if not drawn:
        return None
    fixed = [shape for shape in drawn if not model.body_weldid[shape.body]]
    moving = [shape for shape in drawn if model.body_weldid[shape.body]]
    extent = _extent(model, drawn)
    shown, rate = _recordings(first, max(1, len(moving) * (1 + len(found.compared))))
    errors = np.abs(np.concatenate([first.traces.error]))
    return {
        "extent": extent,
        "rate": rate,
        "bodies": [_shape(shape, extent) for shape in moving],
        "fixed": [_shape(shape, extent) | {"pose": _rest(model, shape)} for shape in fixed],
        "joint": [_joint_of(model, shape.body, first.traces.joints) for shape in moving],
        "largest_rad": float(np.percentile(errors, COLOURED)) or 1e-6,
        "recordings": [_recording(found, model, moving, extent, i, rate) for i in shown],
        "left_out": len(first.traces.recordings) - len(shown),
    }


def _model(compared: Compared) -> mujoco.MjModel | None:
    """The robot with its shapes, or where those are not there, as the simulation has it."""
    robot, joints = compared.numbers.get("robot_file"), compared.traces.joints
    if not isinstance(robot, str):
        return None
    try:
        try:
            return plant.read(robot).compile()
        except ValueError:
            return plant.compiled(plant.load(robot, joints), robot)
    except T2LError:
        return None


def _joints(model: mujoco.MjModel) -> set[str]:
    return {model.joint(i).name for i in range(model.njnt)}


def _extent(model: mujoco.MjModel, drawn) -> float:
    """The largest distance from the base that anything can be drawn at, about, in m."""
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    reach = [
        np.linalg.norm(data.xpos[s.body]) + np.linalg.norm(s.vertices, axis=1).max() for s in drawn
    ]
    return float(max(*reach, 1e-3)) * 1.5


def _recordings(compared: Compared, bodies: int) -> tuple[list[int], float]:
    """Which recordings are shown, and at how many poses a second."""
    traces, logs = compared.traces, compared.numbers["logs"]
    shown = recordings_to_show(traces)
    most = MOST_POSES / bodies
    squares = np.bincount(traces.recording, traces.error**2, len(logs))
    kept, total = [], 0.0
    for i in sorted(shown, key=lambda i: -squares[i]):
        if kept and (total + logs[i]["duration_s"]) * SLOWEST_HZ > most:
            continue
        kept.append(i)
        total += logs[i]["duration_s"]
    return sorted(kept), float(np.clip(most / max(total, 1e-9), SLOWEST_HZ, FASTEST_HZ))


def _recording(found: Found, model, moving, extent, index: int, rate: float) -> dict[str, Any]:
    traces = found.compared[0].traces
    joints = range(len(traces.joints))
    rows = [traces.at(index, joint) for joint in joints]
    end = min(traces.columns["time"][at].max(initial=0.0) for at in rows)
    # one that is longer than all poses together is cut
    count = min(int(end * rate) + 1, MOST_POSES // max(1, len(moving)))
    time = np.arange(count) / rate

    def course(compared: Compared, name: str) -> np.ndarray:
        columns = compared.traces.columns
        return np.stack([np.interp(time, columns["time"][at], columns[name][at]) for at in rows], 1)

    measured = course(found.compared[0], "q")
    simulated = [course(compared, "q_sim") for compared in found.compared]
    return {
        "name": traces.recordings[index],
        "count": count,
        "poses": [
            _int16(_poses(model, traces.joints, q, moving, extent)) for q in (measured, *simulated)
        ],
        "errors": [_float32(np.abs(measured - q)) for q in simulated],
    }


def _poses(model, joints, q: np.ndarray, moving, extent: float) -> np.ndarray:
    """(n, nbody, 7): place over `extent`, and quaternion x, y, z, w, each times `FULL`."""
    data = mujoco.MjData(model)
    address = [model.joint(name).qposadr[0] for name in joints]
    bodies = [shape.body for shape in moving]
    poses = np.empty((len(q), len(bodies), 7))
    for i, row in enumerate(q):
        data.qpos[address] = row
        mujoco.mj_kinematics(model, data)
        poses[i, :, :3] = data.xpos[bodies] / extent
        poses[i, :, 3:] = data.xquat[bodies][:, [1, 2, 3, 0]]
    return FULL * np.clip(poses, -1, 1)


def _rest(model: mujoco.MjModel, shape) -> list[float]:
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    return [*data.xpos[shape.body].tolist(), *data.xquat[shape.body][[1, 2, 3, 0]].tolist()]


def _shape(shape, extent: float) -> dict[str, str]:
    scaled = FULL * np.clip(shape.vertices / extent, -1, 1)
    triangles = base64.b64encode(shape.triangles.astype("<u4").tobytes()).decode()
    return {"vertices": _int16(scaled), "triangles": triangles}


def _joint_of(model: mujoco.MjModel, body: int, joints: tuple[str, ...]) -> int:
    """Which of `joints` moves a body last; -1 if none does."""
    while body:
        first = model.body_jntadr[body]
        for joint in range(first, first + model.body_jntnum[body]):
            if (name := model.joint(joint).name) in joints:
                return joints.index(name)
        body = model.body_parentid[body]
    return -1


def _int16(values: np.ndarray) -> str:
    return base64.b64encode(np.round(values).astype("<i2").tobytes()).decode()


def _float32(values: np.ndarray) -> str:
    return base64.b64encode(values.astype("<f4").tobytes()).decode()
