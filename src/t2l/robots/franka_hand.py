"""Franka Hand: two fingers that move as one, position-actuated with a force limit.

Dimensions, masses and forces are those of the Franka Hand's product manual: 0.73 kg, 80 mm
stroke, 70 N continuous grasping force, fingertips 103.4 mm below the flange.
"""

import math

import mujoco

from t2l.robots.robot import Gripper
from t2l.robots.specs import COLLIDES_WITH_SCENE, add_position_actuator, add_wrist_camera

JOINTS = ("finger_joint1", "finger_joint2")
GRIP_SITE = "grip"
OPEN = 0.04  # m, each finger
GRASP_FORCE = 70.0  # N

HAND_MASS = 0.70  # kg, without the fingers
FINGER_MASS = 0.015  # kg
FINGER_Z = 0.0584  # m, finger joint below the flange
TIP_Z = 0.1034  # m, between the fingertips

GRIPPER = Gripper(
    joints=JOINTS,
    actuators=JOINTS,
    closed=0.0,
    opened=OPEN,
    opened_qpos=(OPEN, OPEN),
    opening_m=2 * OPEN,
)


def attach(link: mujoco.MjsBody, flange: mujoco.MjsSite, visual: bool) -> None:
    """Mount the hand on `link` at `flange`, turned by -45° as Franka does.

    Args:
        visual: show the fingers above their pads too, and add a camera.
    """
    hand = link.add_body(
        name="hand",
        pos=flange.pos,
        quat=(math.cos(math.pi / 8), 0, 0, -math.sin(math.pi / 8)),
        mass=HAND_MASS,
        ipos=(-0.01, 0, 0.03),
        inertia=(0.001, 0.0025, 0.0017),
        explicitinertial=True,
    )
    box = mujoco.mjtGeom.mjGEOM_BOX
    hand.add_geom(
        name="hand_box",
        type=box,
        pos=(0, 0, 0.035),
        size=(0.018, 0.10, 0.03),
        rgba=(0.9, 0.9, 0.9, 1),
        **{**COLLIDES_WITH_SCENE, "group": 2},
    )
    hand.add_site(name=GRIP_SITE, pos=(0, 0, TIP_Z))
    if visual:
        add_wrist_camera(hand, TIP_Z)
    for name, side in zip(JOINTS, (1.0, -1.0), strict=True):
        finger = hand.add_body(
            name=name.replace("joint", ""),
            pos=(0, 0, FINGER_Z),
            mass=FINGER_MASS,
            ipos=(0, 0, 0.03),
            inertia=(3e-6, 3e-6, 1e-6),
            explicitinertial=True,
        )
        finger.add_joint(
            name=name,
            type=mujoco.mjtJoint.mjJNT_SLIDE,
            axis=(0, side, 0),
            range=(0, OPEN),
            armature=0.1,
            damping=10.0,
        )
        if visual:
            finger.add_geom(
                name=name.replace("joint", "rod"),
                type=box,
                pos=(0, side * 0.010, 0.009),
                size=(0.009, 0.008, 0.012),
                mass=0,
                rgba=(0.75, 0.75, 0.75, 1),
                contype=0,
                conaffinity=0,
                group=2,
            )
        # the flat pad of the fingertip; its inner face lies in the plane of symmetry when closed
        finger.add_geom(
            name=name.replace("joint", "pad"),
            type=box,
            pos=(0, side * 0.0075, 0.036),
            size=(0.0085, 0.0075, 0.018),
            condim=4,
            friction=(1.0, 0.005, 0.0001),
            rgba=(0.2, 0.2, 0.2, 1),
            **{**COLLIDES_WITH_SCENE, "group": 2},
        )


def add_actuators(spec: mujoco.MjSpec) -> None:
    """Couple the fingers and drive both with the same position command, in m."""
    first, second = JOINTS
    spec.add_equality(
        type=mujoco.mjtEq.mjEQ_JOINT,
        name1=first,
        name2=second,
        objtype=mujoco.mjtObj.mjOBJ_JOINT,
        data=[0, 1] + [0] * 10,
        solref=(0.004, 1),
        solimp=(0.999, 0.9999, 0.001, 0.5, 2),
    )
    for joint in JOINTS:
        actuator = add_position_actuator(spec, joint, kp=5000.0, kv=200.0)
        actuator.forcelimited = True
        actuator.forcerange = (-GRASP_FORCE / 2, GRASP_FORCE / 2)
        actuator.ctrllimited = True
        actuator.ctrlrange = (0, OPEN)
