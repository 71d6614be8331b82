"""A spring between motor and link."""

import numpy as np

from t2l.effects import two_mass
from t2l.effects.effect import Effect, Parameter


class JointFlexibility(Effect):
    """τ = k (q_motor − q_link) + d (q̇_motor − q̇_link)."""

    name = "joint_flexibility"
    title = "joint flexibility"
    parameters = (
        Parameter(
            "stiffness", "N·m/rad", 10.0, 4e6, "of gearbox and link", neutral=np.inf, log=True,
            scale="inertia",
        ),
        Parameter(
            "damping", "N·m·s/rad", 1e-3, 1e4, "across the spring", log=True, scale="inertia"
        ),
        Parameter(
            "encoder_on_link", "0 or 1", 0.0, 1.0, "what the encoder measures", per_joint=False,
            rough=True,
        ),
    )  # fmt: skip
    summary = "gearbox and link give like a spring between the motor and what it moves"
    signature = "the response swings after fast motion at a frequency that no gain explains"
    source = "Spong, Modeling and control of elastic joint robots, 1987, eq. 15"
    follows = "acceleration"
    hides_state = True
    coupled = True
    remembers = False  # what it does it does to the plant
    every_s = 0.001  # numerics: what gives is steered through the motor alone

    def extend(self, spec, joints):
        for name in joints:
            two_mass.add_joint(spec, name, "flexibility")

    def export(self, to, joints, values):
        for i, j in enumerate(joints):
            spring = to.spec.joint(f"{to.joints[j]}/flexibility")
            spring.stiffness[0], spring.damping[0] = values["stiffness"][i], values["damping"][i]
        two_mass.export_encoder(to, self.name, joints, "flexibility", values["encoder_on_link"])

    def install(self, loop, rows, joints, values):
        qpos, dofs = two_mass.addresses(loop, joints, "flexibility")
        stiffness = values["stiffness"]
        added = [loop.batch.model.joint(f"{loop.joints[j]}/flexibility").id for j in joints]
        loop.batch.expand("jnt_stiffness")[rows, added] = stiffness
        loop.batch.expand("dof_damping")[rows, dofs] = values["damping"]
        two_mass.gravity_compensation_on_motor_only(loop, rows, dofs)
        link = values["encoder_on_link"]
        two_mass.give(loop, rows, joints, stiffness, values["damping"], 0.0, link)
        two_mass.encoder_at(loop, rows, joints, qpos, dofs, link)

        def angle(load):
            return -load / stiffness

        two_mass.start_under_load(loop, rows, joints, (qpos, dofs), link, angle)

    def starts(self, scales):
        def guess(frequency, link):
            stiffness = scales.inertia * (2 * np.pi * frequency) ** 2
            return {
                "stiffness": stiffness,
                "damping": 0.3 * stiffness / (np.pi * frequency),
                "encoder_on_link": np.array([link]),
            }

        return [guess(f, link) for f in (3.0, 6.0, 12.0, 24.0) for link in (0.0, 1.0)]
