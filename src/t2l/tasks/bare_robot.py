"""A robot alone, which reaches for what is not there, and how it is seen."""

import mujoco

from t2l.robots import Robot
from t2l.robots.plant import position_controlled
from t2l.tasks.table_top import stage_lights

# of the camera: position in m, its right and up; it has the whole arm of a robot of a metre in view
OVERVIEW = ((1.7, -1.3, 1.0), (0.66, 0.76, 0, -0.20, 0.17, 0.96))
VIEW_DEG = 36
FLOOR = (0.93, 0.92, 0.90, 1)


def bare_scene(robot: Robot, visual: bool) -> mujoco.MjSpec:
    """The robot; on a floor that touches nothing, with light and the camera `overview` if seen."""
    if not visual:
        return position_controlled(robot)
    spec = robot.spec(visual=True)
    stage_lights(spec)
    plane = mujoco.mjtGeom.mjGEOM_PLANE
    spec.worldbody.add_geom(
        name="floor", type=plane, size=(2, 2, 0.05), rgba=FLOOR, contype=0, conaffinity=0
    )
    position, axes = OVERVIEW
    spec.worldbody.add_camera(name="overview", pos=position, xyaxes=axes, fovy=VIEW_DEG)
    return spec
