"""A cable or belt that runs along two joints."""

import numpy as np

from t2l.effects.effect import Effect, Parameter
from t2l.sim.loop import over_ticks


class JointCoupling(Effect):
    """A tendon of length L = q_i + r q_(i−1): τ_i = −k (L − L0) − d L̇, and τ_(i−1) = r τ_i.

    So a torque of one joint follows position and velocity of the joint before it, and no energy
    comes from nowhere.
    """

    name = "joint_coupling"
    title = "coupling of two joints"
    parameters = (
        Parameter("stiffness", "N·m/rad", 0.0, 100.0, "of the cable, k", scale="torque / range"),
        Parameter(
            "damping", "N·m·s/rad", 0.0, 100.0, "of the cable, d", size=0.01,
            scale="torque / velocity",
        ),
        Parameter(
            "ratio", "1", -5.0, 5.0, "of the lever arms, of the joint before over this one, r",
            neutral=np.nan, size=0.3,
        ),
        Parameter("rest", "rad", -30.0, 30.0, "where it is slack, L0", neutral=np.nan, size=0.3),
    )  # fmt: skip
    summary = "a cable or belt along a joint and the one before it ties the two elastically"
    signature = "the torque that one joint lacks follows the position of its neighbour"
    source = "MuJoCo, XML reference, tendon/fixed: a spring and damper over a sum of joints"
    remembers = False
    follows = "position"
    coupled = True
    least_joints = 2

    def export(self, to, joints, values):
        for i, j in enumerate(joints):
            if j == 0:
                continue
            tendon = to.spec.add_tendon(name=f"{to.joints[j]}/coupling")
            tendon.stiffness[0], tendon.damping[0] = values["stiffness"][i], values["damping"][i]
            tendon.springlength = (values["rest"][i],) * 2
            tendon.wrap_joint(to.joints[j], 1.0)
            tendon.wrap_joint(to.joints[j - 1], values["ratio"][i])

    def install(self, loop, rows, joints, values):
        here = joints[joints > 0]
        own = {name: value[:, joints > 0] for name, value in values.items()}
        stiffness, damping, ratio, rest = (
            own[name] for name in ("stiffness", "damping", "ratio", "rest")
        )

        @over_ticks
        def add(tick, q, dq, torque):
            rate = dq[..., rows, here] + ratio * dq[..., rows, here - 1]
            length = q[..., rows, here] + ratio * q[..., rows, here - 1]
            pull = -stiffness * (length - rest) - damping * rate
            torque[..., rows, here] += pull
            torque[..., rows, here - 1] += ratio * pull

        loop.joint_torques.append(add)

    def starts(self, scales):
        one = np.ones_like(scales.torque)
        stiffness = scales.torque / scales.range
        before = np.concatenate([scales.centre[:1], scales.centre[:-1]])
        return [
            {
                "stiffness": f * stiffness,
                "damping": 0.0 * one,
                "ratio": ratio * one,
                "rest": scales.centre + ratio * before,  # slack in the middle of the motion
            }
            for f in (0.1, 1.0)
            for ratio in (1.0, -1.0)
        ]
