"""Dry friction that grows with the torque through the gearbox."""

import numpy as np

from t2l.effects.coulomb_friction import export_friction
from t2l.effects.effect import Effect, Parameter
from t2l.sim.loop import over_ticks


class LoadDependentFriction(Effect):
    """Bound of the friction torque: |μm τ_motor − μl τ_load|."""

    name = "load_dependent_friction"
    title = "load-dependent friction"
    parameters = (
        Parameter("motor", "1", 0.0, 1.0, "friction per motor torque", kinked=True),
        Parameter(
            "load", "1", 0.0, 1.0, "friction per external torque (gravity, Coriolis)", kinked=True
        ),
    )
    summary = "dry friction of gear teeth under load, in proportion to the torque they transmit"
    signature = "the error follows the direction of motion and grows with the torque transmitted"
    source = "Duclusaud et al., Extended friction models for servo actuators, 2024, models M3, M5"
    remembers = False
    follows = "load"

    def export(self, to, joints, values):
        export_friction(to, joints, np.zeros(len(joints)))
        to.call(self.name, teeth_under_load, joints, values)

    def install(self, loop, rows, joints, values):
        loads, at = loop.loads(), (..., rows, loop.columns(joints))

        @over_ticks
        def add(tick, dq, motor, level):
            # what acts from outside is against what the motion asks for
            level[at] += np.abs(values["motor"] * motor[at] + values["load"] * loads(tick)[at])

        loop.friction.append(add)

    def starts(self, scales):
        one = np.ones_like(scales.torque)
        return [
            {"motor": motor * one, "load": load * one}
            for motor, load in ((0.03, 0.0), (0.015, 0.015), (0.2, 0.0), (0.1, 0.1))
        ]


def teeth_under_load(robot, joints, values):
    """Add friction in proportion to the torque that the gears transmit."""
    torque = values["motor"] * robot.motor[joints] + values["load"] * robot.load[joints]
    robot.friction[joints] += np.abs(torque)
