"""Flat ground with a robot on it that walks, and what its feet and its trunk feel."""

import mujoco

from t2l.robots import Robot
from t2l.sim.arrays import Array, namespace
from t2l.sim.batch import TIMESTEP_S
from t2l.tasks.table_top import STANDS, stage_lights

GROUND = "ground"
# format: of MuJoCo's contact sensor, what it tells (bit of the force) and how contacts are reduced
FORCE, NET = 2, 3
AXES = 3


def ground_scene(robot: Robot, visual: bool) -> mujoco.MjSpec:
    """A robot that walks, on flat ground; `felt` reads its sensors.

    Args:
        visual: whether it is to be seen, by the camera `overview`, which goes with the robot.
    """
    spec, walker = robot.spec(gravity_compensation=False, visual=visual), robot.walker
    spec.option.timestep = TIMESTEP_S
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_DISCRETE
    plane = mujoco.mjtGeom.mjGEOM_PLANE
    spec.worldbody.add_geom(name=GROUND, type=plane, size=(0, 0, 0.05), **STANDS)
    for body in (*walker.feet, walker.trunk):
        # the force of all contacts together, as IsaacLab's sensor has it
        spec.add_sensor(
            name=f"contact.{body}", type=mujoco.mjtSensor.mjSENS_CONTACT,
            objtype=mujoco.mjtObj.mjOBJ_BODY, objname=body, intprm=(FORCE, NET, 1),
        )  # fmt: skip
    for body in walker.feet:
        spec.add_sensor(
            name=f"velocity.{body}", type=mujoco.mjtSensor.mjSENS_FRAMELINVEL,
            objtype=mujoco.mjtObj.mjOBJ_XBODY, objname=body,
        )  # fmt: skip
    if visual:
        _stage(spec, spec.joint(walker.base).parent)
    return spec


def felt(sensed: Array, feet: int) -> tuple[Array, Array]:
    """Force on each foot and then the trunk, (n, feet + 1, 3) N, and velocities of feet, m/s.

    Args:
        sensed: sensor data of the scene, (n, …), of the state before the last step.
        feet: how many there are.
    """
    xp, forces = namespace(sensed), AXES * (feet + 1)
    return (
        xp.reshape(sensed[:, :forces], (-1, feet + 1, AXES)),
        xp.reshape(sensed[:, forces:], (-1, feet, AXES)),
    )


def _stage(spec: mujoco.MjSpec, body: mujoco.MjsBody) -> None:
    """Light, tiles of half a metre, and a camera before a body, to its right."""
    stage_lights(spec)
    # it is to shine wherever the robot goes
    spec.lights[-1].type = mujoco.mjtLightType.mjLIGHT_DIRECTIONAL
    spec.add_texture(
        name=GROUND, type=mujoco.mjtTexture.mjTEXTURE_2D, width=128, height=128,
        builtin=mujoco.mjtBuiltin.mjBUILTIN_CHECKER,
        rgb1=(0.93, 0.92, 0.90), rgb2=(0.86, 0.85, 0.83),
    )  # fmt: skip
    tiles = spec.add_material(name=GROUND, texuniform=True, texrepeat=(1, 1))
    tiles.textures[mujoco.mjtTextureRole.mjTEXROLE_RGB] = GROUND
    spec.geom(GROUND).material = GROUND
    body.add_camera(
        name="overview", mode=mujoco.mjtCamLight.mjCAMLIGHT_TRACK, pos=(1.7, -1.35, 0.2),
        xyaxes=(0.62, 0.78, 0, -0.1, 0.08, 0.99), fovy=42,
    )  # fmt: skip
