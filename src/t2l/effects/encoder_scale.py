"""An encoder that counts too much or too little."""

import numpy as np

from t2l.effects.effect import Effect, Parameter
from t2l.sim.loop import over_ticks


class EncoderScale(Effect):
    """q_measured = q0 + (1 + s) (q − q0), with the position q0 at the start."""

    name = "encoder_scale"
    title = "encoder scale"
    parameters = (Parameter("error", "1", -0.5, 0.5, "measured over true motion, minus one, s"),)
    summary = "the encoder reads the motion since the start by a factor too large or too small"
    signature = "the error grows with the distance from the start, alike at all gains"
    source = (
        "Hollerbach, Khalil and Gautier, Model identification, Springer handbook of robotics, "
        "2016: gains of joint angle sensors"
    )
    remembers = False
    follows = "position"

    def export(self, to, joints, values):
        to.cannot_carry(self.name, "MuJoCo's actuators read the true position of a joint")

    def install(self, loop, rows, joints, values):
        at, factor = (..., rows, loop.columns(joints)), 1 + values["error"]
        # measured, whatever other effects make of it
        start = loop.start_q[at]

        @over_ticks
        def change(tick, q, dq):
            q[at] = start + factor * (q[at] - start)
            dq[at] *= factor

        loop.sensor_filters.append(change)

    def starts(self, scales):
        one = np.ones_like(scales.torque)
        return [{"error": f * one} for f in (0.01, -0.01, 0.05, -0.05)]
