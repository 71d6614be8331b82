"""Torque ripple over the angle of the motor."""

import numpy as np

from t2l.effects.effect import Effect, Parameter


class Cogging(Effect):
    """τ = a sin(N q) + b cos(N q)."""

    name = "cogging"
    title = "cogging"
    parameters = (
        Parameter("sine", "N·m", -20.0, 20.0, "amplitude of sin(N q)"),
        Parameter("cosine", "N·m", -20.0, 20.0, "amplitude of cos(N q)"),
        Parameter("periods", "1/rev", 3.0, 500.0, "periods in a turn of the joint, N", log=True),
    )
    summary = "torque that ripples with the joint angle, from magnets and gear teeth"
    signature = "the error repeats over the position, alike in both directions"
    source = "MuJoCo, DC motor technical note, section 1.2"
    follows = "position"
    amplitudes = ("sine", "cosine")

    def install(self, loop, rows, joints, values):
        at = rows, loop.columns(joints)

        def add(tick, q, dq, torque):
            # the angle in the middle of the period for which the torque is held
            angle = values["periods"] * (q[at] + 0.5 * loop.period_s * dq[at])
            torque[at] += values["sine"] * np.sin(angle) + values["cosine"] * np.cos(angle)

        loop.joint_torques.append(add)

    def starts(self, scales):
        one, level = np.ones_like(scales.torque), 0.1 * scales.torque
        # neighbours differ by half a period over the range that is moved
        span = max(float(scales.range.max()), 0.05)
        step = np.pi / span
        periods = np.arange(4.0, 130.0, max(step, 2.0))
        return [
            {"sine": s * level, "cosine": c * level, "periods": n * one}
            for n in periods
            for s, c in ((1.0, 0.0), (0.0, 1.0))
        ]
