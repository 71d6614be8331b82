"""Robotiq 2F-85: two fingers on linkages that one motor closes.

The model is MuJoCo Menagerie's with its tendon, its equality constraints and their solver
parameters; colliders are the pads and the housing.
"""

import mujoco

from t2l.robots import menagerie
from t2l.robots.robot import Gripper
from t2l.robots.specs import COLLIDES_WITH_SCENE, WRIST_CAMERA, add_wrist_camera

PREFIX = "gripper/"
GRIP_SITE = f"{PREFIX}grip"

# in the frame of the gripper's base: between the middles of the lower pads when they are 4 cm
# apart, 9 mm above the fingertips; Menagerie's `pinch` is where the pads are when opened
GRIP_Z = 0.1516  # m

GRIPPER = Gripper(
    joints=tuple(
        f"{PREFIX}{side}_{part}_joint"
        for side in ("right", "left")
        for part in ("driver", "coupler", "spring_link", "follower")
    ),
    actuators=(f"{PREFIX}fingers_actuator",),
    # the gripper's own unit, a byte
    closed=255.0,
    opened=0.0,
    opened_qpos=(0.0,) * 8,
    # Robotiq 2F-85 instruction manual: stroke
    opening_m=0.085,
)

# kg, m and kg·m²: what MuJoCo takes from the meshes of the bodies whose inertia the MJCF leaves
# to them, so that it is the same where meshes are dropped
_INERTIA = {
    "base_mount": (0.150, (-3.6e-4, 0.9e-4, -0.6e-4), (1.023e-4, 5.36e-5, 5.22e-5)),
    "right_silicone_pad": (0.0013, (0, -0.0058, 0.0185), (2.01e-7, 1.50e-7, 5.2e-8)),
    "left_silicone_pad": (0.0013, (0, -0.0058, 0.0185), (2.01e-7, 1.50e-7, 5.2e-8)),
}


def attach(spec: mujoco.MjSpec, flange: mujoco.MjsSite, visual: bool) -> None:
    """Mount the gripper on `flange` of a robot; its names get `PREFIX`, but for its camera's.

    Raises:
        ConfigurationError: its model is not installed.
    """
    gripper = mujoco.MjSpec.from_file(str(menagerie.model("robotiq_2f85", "2f85.xml")))
    for name, (mass, ipos, inertia) in _INERTIA.items():
        body = gripper.body(name)
        body.mass, body.ipos, body.inertia = mass, ipos, inertia
        body.explicitinertial = True
    for geom in list(gripper.geoms):
        if geom.type == mujoco.mjtGeom.mjGEOM_BOX:
            for key, value in COLLIDES_WITH_SCENE.items():
                setattr(geom, key, value)
        elif geom.contype or not visual:
            gripper.delete(geom)
    if not visual:
        for mesh in list(gripper.meshes):
            gripper.delete(mesh)
    base = gripper.body("base")
    base.add_site(name="grip", pos=(0, 0, GRIP_Z))
    if visual:
        add_wrist_camera(base, GRIP_Z)
    # the housing, read off the mesh
    base.add_geom(
        name="housing",
        type=mujoco.mjtGeom.mjGEOM_CAPSULE,
        fromto=(0, -0.03, 0.055, 0, 0.03, 0.055),
        size=(0.035, 0, 0),
        **COLLIDES_WITH_SCENE,
    )
    # friction cones as the MJCF asks for, which do not let go of what they hold
    spec.option.cone, spec.option.impratio = gripper.option.cone, gripper.option.impratio
    # `attach` wants the options of both to be equal
    gripper.option = spec.option
    spec.attach(gripper, site=flange, prefix=PREFIX)
    if visual:
        spec.camera(f"{PREFIX}{WRIST_CAMERA}").name = WRIST_CAMERA
