"""A cable or belt that runs along two joints."""

import numpy as np

from t2l.effects.effect import Effect, Parameter
from t2l.sim.loop import over_ticks


class JointCoupling(Effect):
    """A tendon of length L = q_i + r q_j: τ_i = −k (L − L0) − d L̇, and τ_j = r τ_i.

    So a torque of one joint follows position and velocity of one before it, j = i − `before`, and
    no energy comes from nowhere.
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
            "ratio", "1", -5.0, 5.0, "of the lever arms, of the other joint over this one, r",
            neutral=np.nan, size=0.3,
        ),
        Parameter("rest", "rad", -30.0, 30.0, "where it is slack, L0", neutral=np.nan, size=0.3),
        Parameter(
            "before", "1", 1.0, 100.0, "how many joints before this one the other is",
            neutral=np.nan, rough=True, default=1.0,
        ),
    )  # fmt: skip
    summary = "a cable or belt along a joint and one before it ties the two elastically"
    signature = "the torque that one joint lacks follows the position of another"
    source = "MuJoCo, XML reference, tendon/fixed: a spring and damper over a sum of joints"
    remembers = False
    follows = "position"
    coupled = True
    least_joints = 2

    def places(self, joints):
        return tuple(range(1, len(joints)))

    def check(self, joints, values):
        for name, before in values["before"].items():
            place = joints.index(name)
            if not place and not (values["stiffness"][name] or values["damping"][name]):
                continue
            if not (before <= place and float(before).is_integer()):
                raise ValueError(
                    f"found before = {before:g} of {name}; allowed: a whole number up to {place}, "
                    "as so many joints are before it"
                )

    def export(self, to, joints, values):
        for i, j in enumerate(joints):
            if j == 0:
                continue
            tendon = to.spec.add_tendon(name=f"{to.joints[j]}/coupling")
            tendon.stiffness[0], tendon.damping[0] = values["stiffness"][i], values["damping"][i]
            tendon.springlength = (values["rest"][i],) * 2
            tendon.wrap_joint(to.joints[j], 1.0)
            tendon.wrap_joint(to.joints[j - round(values["before"][i])], values["ratio"][i])

    def install(self, loop, rows, joints, values):
        others = joints - values["before"].round().astype(int)
        cables = [
            (slice(rows.start + first, rows.start + end), joint, others[first, i], first, end, i)
            for i, joint in enumerate(joints)
            if joint > 0
            for first, end in _alike(others[:, i])
        ]

        @over_ticks
        def add(tick, q, dq, torque):
            for row, joint, other, first, end, i in cables:
                stiffness, damping, ratio, rest = (
                    values[name][first:end, i] for name in ("stiffness", "damping", "ratio", "rest")
                )
                length, rate = (x[..., row, joint] + ratio * x[..., row, other] for x in (q, dq))
                pull = -stiffness * (length - rest) - damping * rate
                torque[..., row, joint] += pull
                torque[..., row, other] += ratio * pull

        loop.joint_torques.append(add)

    def starts(self, scales):
        place = np.arange(len(scales.torque))
        one = np.ones(len(place))
        found = []
        for before in range(1, max(len(place), 2)):
            apart = np.clip(before, 1, np.maximum(place, 1))
            found += [
                {
                    # its torque is proportional to it, so that one guess is enough
                    "stiffness": 0.3 * scales.torque / scales.range,
                    "damping": 0.0 * one,
                    "ratio": ratio * one,
                    # slack in the middle of the motion
                    "rest": scales.centre + ratio * scales.centre[place - np.minimum(apart, place)],
                    "before": 1.0 * apart,
                }
                for ratio in (1.0, -1.0)
            ]
        return found


def _alike(values):
    """Stretches (first, end) of equal values (n,)."""
    ends = [*(np.flatnonzero(np.diff(values)) + 1).tolist(), len(values)]
    return list(zip([0, *ends[:-1]], ends, strict=True))
