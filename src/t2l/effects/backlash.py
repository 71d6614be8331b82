"""Play between motor and link."""

import numpy as np

from t2l.effects import two_mass
from t2l.effects.effect import Effect, Parameter

DAMPING_RATIO = 0.3  # of closed teeth: steel on steel, lightly damped


class Backlash(Effect):
    """The link moves freely against the motor within ± half the play."""

    name = "backlash"
    title = "backlash"
    parameters = (
        Parameter("play", "rad", 1e-4, 0.5, "how far the link moves freely", log=True),
        Parameter("contact_time", "s", 1e-3, 0.05, "1/ω of the closed teeth", log=True),
        Parameter(
            "encoder_on_link", "0 or 1", 0.0, 1.0, "what the encoder measures", per_joint=False,
            rough=True,
        ),
    )  # fmt: skip
    summary = "gears with play: the link is free within a small angle of the motor"
    signature = "the response differs after each reversal, until the gears meet again"
    source = "MuJoCo joint limits on a second joint; Nordin and Gutman, 2002"
    follows = "direction"
    rough_error = True

    def extend(self, spec, joints):
        for name in joints:
            between = two_mass.add_joint(spec, name, "backlash")
            between.limited = 1
            between.range = (-0.01, 0.01)
            between.solimp_limit[:2] = (0.999, 0.9999)

    def install(self, loop, rows, joints, values):
        qpos, dofs = two_mass.addresses(loop, joints, "backlash")
        added = [loop.batch.model.joint(f"{loop.joints[j]}/backlash").id for j in joints]
        half = 0.5 * values["play"]
        limits = loop.batch.expand("jnt_range")
        limits[rows, added, 0], limits[rows, added, 1] = -half, half
        contact = loop.batch.expand("jnt_solref")
        contact[rows, added, 0] = values["contact_time"] / DAMPING_RATIO
        contact[rows, added, 1] = DAMPING_RATIO
        two_mass.gravity_compensation_on_motor_only(loop, rows, dofs)
        link = values["encoder_on_link"]
        two_mass.encoder_at(loop, rows, joints, qpos, dofs, link)

        bias = loop.batch.bind("qfrc_bias")  # before the start is computed, which fills it

        def settle(loop):
            rest = -np.sign(bias[rows, dofs]) * half
            loop.batch.qpos[rows, qpos] = rest
            loop.batch.qpos[rows, loop.qpos[joints]] -= link * rest

        loop.settle.append(settle)

    def starts(self, scales):
        one = np.ones_like(scales.torque)
        return [
            {"play": play * one, "contact_time": 3e-3 * one, "encoder_on_link": np.array([link])}
            for play in (0.003, 0.01, 0.03, 0.08)
            for link in (0.0, 1.0)
        ]
