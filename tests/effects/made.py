"""Sizes of a robot that nobody recorded, whose masses and forces are multiples of a factor."""

from dataclasses import fields

import mujoco
import numpy as np

from t2l.effects.effect import Scales

HAS = {"armature": 0.1, "damping": 0.2, "friction": 0.3}
# powers of the factor
POWERS = {"velocity": 0, "control_rate_hz": 0, "range": 0, "centre": 0}


def made_sizes(joints=("a", "b"), factor=1.0) -> Scales:
    """Different of each joint."""
    rng = np.random.default_rng(0)
    values = {}
    for field in fields(Scales):
        power = POWERS.get(field.name, 1)
        values[field.name] = rng.uniform(0.3, 3.0, len(joints)) * factor**power
    values |= {"control_rate_hz": 1000.0, "plant": chain(joints, factor), "joints": tuple(joints)}
    values |= {k: np.full(len(joints), own * factor) for k, own in HAS.items()}
    values["total_torque"] = np.full(len(joints), values["torque"].sum())
    return Scales(**values)


def chain(joints, factor=1.0) -> mujoco.MjModel:
    """Links of 1 kg on one another, with friction, damping and armature, all times the factor."""
    names = {"armature": "armature", "damping": "damping", "friction": "frictionloss"}
    has = " ".join(f'{names[key]}="{own * factor!r}"' for key, own in HAS.items())
    inertia = " ".join([repr(0.01 * factor)] * 3)
    body = "".join(
        f'<body pos="0 0 0.3"><joint name="{name}" axis="0 1 0" {has}/>'
        f'<inertial pos="0.1 0 0.15" mass="{factor!r}" diaginertia="{inertia}"/>'
        for name in joints
    )
    ends = '<site name="flange" pos="0.1 0 0.3"/>' + "</body>" * len(joints)
    return mujoco.MjModel.from_xml_string(f"<mujoco><worldbody>{body}{ends}</worldbody></mujoco>")
