"""Play between motor and link."""

import numpy as np

from t2l.effects import two_mass
from t2l.effects.effect import Effect, Parameter

# numerics: of the load that MuJoCo's limits bear without giving way; the rest they bear as a spring
# does
RIGID_SHARE = 1e-3


class Backlash(Effect):
    """The link moves freely against the motor within ± half the play."""

    name = "backlash"
    title = "backlash"
    parameters = (
        Parameter("play", "rad", 1e-4, 0.5, "how far the link moves freely", log=True),
        Parameter("contact_time", "s", 5e-4, 0.05, "1/ω of the closed teeth", log=True),
        Parameter("contact_damping", "1", 0.02, 1.0, "damping ratio of the closed teeth", log=True),
        Parameter(
            "encoder_on_link", "0 or 1", 0.0, 1.0, "what the encoder measures", per_joint=False,
            rough=True,
        ),
    )  # fmt: skip
    summary = "gears with play: the link is free within a small angle of the motor"
    signature = "the response differs after each reversal, until the gears meet again"
    source = "Nordin and Gutman, Controlling mechanical systems with backlash, 2002: dead zone"
    contains = ("joint_flexibility",)  # closed teeth without play
    follows = "direction"
    hides_state = True
    coupled = True
    remembers = False  # what it does it does to the plant
    every_s = 0.001  # numerics: what gives is steered through the motor alone

    def extend(self, spec, joints):
        for name in joints:
            between = two_mass.add_joint(spec, name, "backlash")
            between.limited = 1
            between.range = (-0.01, 0.01)  # guess: until the parameter is set
            between.solimp_limit[:2] = RIGID_SHARE

    def export(self, to, joints, values):
        half = 0.5 * values["play"]
        solref = teeth(values["contact_time"], values["contact_damping"])
        for i, j in enumerate(joints):
            between = to.spec.joint(f"{to.joints[j]}/backlash")
            between.range = -half[i], half[i]
            between.solref_limit = [part[i] for part in solref]
        two_mass.export_encoder(to, self.name, joints, "backlash", values["encoder_on_link"])

    def install(self, loop, rows, joints, values):
        qpos, dofs = two_mass.addresses(loop, joints, "backlash")
        added = [loop.batch.model.joint(f"{loop.joints[j]}/backlash").id for j in joints]
        half = 0.5 * values["play"]
        limits = loop.batch.expand("jnt_range")
        limits[rows, added, 0], limits[rows, added, 1] = -half, half
        contact = loop.batch.expand("jnt_solref")
        solref = teeth(values["contact_time"], values["contact_damping"])
        contact[rows, added, 0], contact[rows, added, 1] = solref
        two_mass.gravity_compensation_on_motor_only(loop, rows, dofs)
        link = values["encoder_on_link"]
        two_mass.encoder_at(loop, rows, joints, qpos, dofs, link)
        compliance = loop.batch.model.dof_invweight0[dofs] * values["contact_time"] ** 2
        damping = 2 * values["contact_damping"] * values["contact_time"] / compliance
        two_mass.give(loop, rows, joints, 1 / compliance, damping, values["play"], link)

        def angle(load):
            return -np.sign(load) * half - compliance * load

        two_mass.start_under_load(loop, rows, joints, (qpos, dofs), link, angle, half)

    def starts(self, scales):
        one = np.ones_like(scales.torque)
        return [
            {
                "play": play * one,
                "contact_time": 3e-3 * one,
                "contact_damping": 0.2 * one,
                "encoder_on_link": np.array([link]),
            }
            for play in (0.003, 0.01, 0.03, 0.08)
            for link in (0.0, 1.0)
        ]


def teeth(contact_time, contact_damping):
    """MuJoCo's solref of teeth: −stiffness and −damping by the inertia on them, 1/s² and 1/s."""
    return -1 / contact_time**2, -2 * contact_damping / contact_time
