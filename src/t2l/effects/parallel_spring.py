"""A spring or an elastic cable beside the motor."""

import numpy as np

from t2l.effects.effect import Effect, Parameter


class ParallelSpring(Effect):
    """τ = −k (q − q0), with q the joint's true position."""

    name = "parallel_spring"
    title = "parallel spring"
    parameters = (
        Parameter(
            "stiffness", "N·m/rad", 0.0, 100.0, "added to the MJCF's, k", scale="torque / range"
        ),
        Parameter(
            "rest", "rad", -30.0, 30.0, "position at which it is slack, q0", neutral=np.nan,
            size=0.3,
        ),
    )  # fmt: skip
    summary = "a spring, or a cable that pulls more the farther the joint is from its rest"
    signature = "the error grows with the distance from one position, alike in both directions"
    source = "MuJoCo, XML reference, joint/stiffness and joint/springref"
    remembers = False
    follows = "position"

    def export(self, to, joints, values):
        pairs = zip(to.each(joints), values["stiffness"], values["rest"], strict=True)
        for joint, stiffness, rest in pairs:
            joint.springref = _together(joint.stiffness[0], joint.springref, stiffness, rest)
            joint.stiffness[0] += stiffness

    def install(self, loop, rows, joints, values):
        ids, qpos = loop.ids[joints], loop.qpos[joints]
        stiffness, rest = loop.batch.expand("jnt_stiffness"), loop.batch.expand("qpos_spring")
        rest[rows, qpos] = _together(
            stiffness[rows, ids], rest[rows, qpos], values["stiffness"], values["rest"]
        )
        stiffness[rows, ids] += values["stiffness"]

    def starts(self, scales):
        stiffness = scales.torque / scales.range
        return [{"stiffness": f * stiffness, "rest": scales.centre} for f in (0.1, 1.0)]

    def read_off(self, q, torque, clock_s):
        slope, at_zero = np.polyfit(q, torque, 1)
        return None if slope >= 0 else {"stiffness": -slope, "rest": -at_zero / slope}


def _together(k, rest, added_k, added_rest):
    """Rest of two springs as one."""
    total = k + added_k
    return np.where(total > 0, (k * rest + added_k * added_rest) / np.maximum(total, 1e-12), rest)
