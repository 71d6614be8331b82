"""An encoder disc that does not turn about its centre."""

import numpy as np

from t2l.effects.effect import Effect, Parameter
from t2l.sim.loop import over_ticks

NEWTON = 8  # numerics: steps at most, each of which doubles the digits
SETTLED_RAD = 1e-12  # numerics: a step that is none


class EncoderEccentricity(Effect):
    """q_measured = q + a sin(q + φ)."""

    name = "encoder_eccentricity"
    title = "encoder eccentricity"
    parameters = (
        Parameter("amplitude", "rad", 0.0, 0.3, "largest error of the reading, a"),
        Parameter(
            "phase", "rad", -30.0, 30.0, "angle of the disc where q is zero, φ", neutral=np.nan
        ),
    )
    summary = "the encoder's disc is off its centre: its reading errs by a sine of the angle"
    signature = "the error repeats once in a turn of the joint, alike at all gains"
    source = "HEIDENHAIN, Angle encoders without integral bearing: eccentricity of the graduation"
    remembers = False
    coupled = True  # the links beyond hang elsewhere
    follows = "position"

    def export(self, to, joints, values):
        to.cannot_carry(self.name, "MuJoCo's actuators read the true position of a joint")

    def install(self, loop, rows, joints, values):
        at = ..., rows, loop.columns(joints)
        amplitude, phase = values["amplitude"], values["phase"]
        true = true_angle(loop.start_q[at], amplitude, phase)
        # the measured start is the reading there
        start = loop.start_q[at] - true
        loop.encoder_offset[at] += start

        @over_ticks
        def change(tick, q, dq):
            angle = q[at] - start
            q[at] = angle + amplitude * np.sin(angle + phase)
            dq[at] *= 1 + amplitude * np.cos(angle + phase)

        loop.sensor_filters.append(change)

    def starts(self, scales):
        one = np.ones_like(scales.torque)
        return [
            {"amplitude": a * one, "phase": phase * one}
            for a in (0.005, 0.03)
            for phase in (-2.0, -0.5, 1.0, 2.5)
        ]


def true_angle(reading, amplitude, phase):
    """The angle at a reading, rad, by Newton's method."""
    q = np.array(reading, float)
    for _ in range(NEWTON):
        step = (q + amplitude * np.sin(q + phase) - reading) / (1 + amplitude * np.cos(q + phase))
        q = q - step
        if not (np.abs(step) > SETTLED_RAD).any():
            break
    return q
