"""A supply whose voltage drops under the load of all motors."""

import numpy as np

from t2l.effects.effect import Effect, Parameter
from t2l.effects.exported import MOTOR
from t2l.sim.loop import over_ticks


class SupplySag(Effect):
    """τ → τ / (1 + k Σ|τ|), over all joints of the robot.

    A motor that a share of the supply voltage V drives gives a torque in proportion to V and draws
    a current in proportion to its torque. An inner resistance R leaves V = V0 − R i of the voltage
    V0, so that V / V0 = 1 − k V / V0 Σ|τ| with all torques τ at V0.
    """

    name = "supply_sag"
    title = "supply sag"
    parameters = (
        Parameter(
            "drop", "1/(N·m)", 0.0, 10.0, "lost of the voltage a torque of all motors, k",
            per_joint=False, scale="1 / total_torque",
        ),
    )  # fmt: skip
    summary = "the supply voltage drops with the torque of all motors, and all of them give less"
    signature = "a joint lacks torque while other joints work hard"
    source = (
        "MuJoCo, DC motor technical note: τ = k_t V / R at rest; Kirchhoff: V = V0 − R i of a "
        "supply with an inner resistance"
    )
    shares = True
    remembers = False
    follows = "torque"
    order = 42

    def export(self, to, joints, values):
        to.call(self.name, sag, joints, values, MOTOR)

    def install(self, loop, rows, joints, values):
        at = ..., rows, loop.columns(joints)

        @over_ticks
        def change(tick, torque):
            work = np.abs(torque[..., rows, :]).sum(axis=-1, keepdims=True)
            torque[at] /= 1 + values["drop"] * work

        loop.motor_filters.append(change)

    def starts(self, scales):
        return [{"drop": f / scales.total_torque[:1]} for f in (0.02, 0.1, 0.3)]


def sag(robot, joints, values):
    """Let all motors give less, the more they give together."""
    robot.motor[joints] /= 1 + values["drop"] * np.abs(robot.motor).sum()
