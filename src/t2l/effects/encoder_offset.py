"""Encoders whose zero is off."""

import numpy as np

from t2l.effects.effect import Effect, Parameter


class EncoderOffset(Effect):
    """q_measured = q + δ, for controller and log alike."""

    name = "encoder_offset"
    title = "encoder offset"
    parameters = (Parameter("offset", "rad", -0.6, 0.6, "measured minus true position"),)
    summary = "the encoder's zero is off: the robot stands elsewhere than it says"
    signature = "the error follows the gravity load as if the arm stood at another angle"
    source = "q_measured = q + δ"
    remembers = False
    follows = "gravity"
    coupled = True  # the links beyond hang elsewhere

    def export(self, to, joints, values):
        to.encoder_offset[joints] += values["offset"]
        # ref is the position that the encoder tells where the MJCF's pose is
        for joint, offset in zip(to.each(joints), values["offset"], strict=True):
            joint.ref += offset
            joint.springref += offset
            if joint.range[0] < joint.range[1]:
                joint.range = np.asarray(joint.range) + offset

    def install(self, loop, rows, joints, values):
        loop.encoder_offset[rows, joints] += values["offset"]

    def starts(self, scales):
        one = np.ones_like(scales.torque)
        return [{"offset": d * one} for d in (0.02, -0.02, 0.1, -0.1)]
