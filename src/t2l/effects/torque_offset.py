"""A constant torque."""

from t2l.effects.effect import Effect, Parameter
from t2l.sim.loop import over_ticks


class TorqueOffset(Effect):
    """τ = τ0."""

    name = "torque_offset"
    title = "torque offset"
    parameters = (
        Parameter("torque", "N·m", -10.0, 10.0, "constant torque on the joint", scale="torque"),
    )
    summary = "a constant torque: imperfect gravity compensation, a cable that pulls"
    signature = "the error keeps one sign, and a compliant gain shows more of it"
    source = "Newton; Gaz et al., Dynamic identification of the Franka Emika Panda, 2019"
    remembers = False
    follows = "constant"

    def export(self, to, joints, values):
        to.constant[joints] += values["torque"]

    def install(self, loop, rows, joints, values):
        at = ..., rows, loop.columns(joints)

        @over_ticks
        def add(tick, q, dq, torque):
            torque[at] += values["torque"]

        loop.joint_torques.append(add)

    def starts(self, scales):
        return [{"torque": factor * scales.torque} for factor in (0.02, -0.02, 0.2, -0.2)]
