"""A motor that small torque commands do not reach."""

import numpy as np

from t2l.effects.effect import Effect, Parameter
from t2l.effects.exported import MOTOR
from t2l.sim.loop import over_ticks


class TorqueDeadZone(Effect):
    """τ → τ − clip(τ, −z, z)."""

    name = "torque_dead_zone"
    title = "torque dead zone"
    parameters = (
        Parameter(
            "zone", "N·m", 0.0, 10.0, "largest command that gives nothing, z", kinked=True,
            scale="torque",
        ),
    )  # fmt: skip
    summary = "a motor command within a zone gives no torque, a larger one what is beyond the zone"
    signature = "the motor gives too little by a constant, in the direction of its command"
    source = "Tao and Kokotović, Adaptive control of plants with unknown dead-zones, 1994"
    remembers = False
    follows = "torque"
    order = 10

    def export(self, to, joints, values):
        to.call(self.name, leave_out_zone, joints, values, MOTOR)

    def install(self, loop, rows, joints, values):
        at, zone = (..., rows, loop.columns(joints)), values["zone"]

        @over_ticks
        def change(tick, torque):
            torque[at] -= np.minimum(np.maximum(torque[at], -zone), zone)

        loop.motor_filters.append(change)

    def starts(self, scales):
        return [{"zone": f * scales.torque} for f in (0.02, 0.1, 0.3, 0.6)]


def leave_out_zone(robot, joints, values):
    """Take the dead zone from the motor torque."""
    motor = robot.motor[joints]
    robot.motor[joints] = motor - np.clip(motor, -values["zone"], values["zone"])
