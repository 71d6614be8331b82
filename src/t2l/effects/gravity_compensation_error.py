"""A compensation of the weight that is off by a factor."""

import numpy as np

from t2l.effects.effect import Effect, Parameter
from t2l.effects.exported import CONTROLLER


class GravityCompensationError(Effect):
    """g(q) → k g(q), in what compensates the weight."""

    name = "gravity_compensation_error"
    title = "wrong gravity compensation"
    parameters = (
        Parameter("factor", "1", -0.5, 3.0, "compensated over modelled weight, k", neutral=1.0),
    )
    summary = "the machine compensates another weight than that of the model"
    signature = "the error follows the weight on the joint, and only where it is compensated"
    source = "De Luca and Panzieri, Learning gravity compensation in robots, 1993"
    remembers = False
    follows = "gravity"
    order = -30

    def may_act(self, recordings):
        return super().may_act(recordings) and any(r.gravity_compensation for r in recordings)

    def export(self, to, joints, values):
        if to.gravity_compensation:
            to.call(self.name, compensate_in_part, joints, values, CONTROLLER)

    def install(self, loop, rows, joints, values):
        loop.compensation_factor[rows, joints] *= values["factor"]

    def starts(self, scales):
        one = np.ones_like(scales.torque)
        return [{"factor": f * one} for f in (0.95, 0.8, 0.5, 1.1, 1.3)]


def compensate_in_part(robot, joints, values):
    """Give a factor of the compensation that the loop gives."""
    weight = robot.gravity
    if robot.compensated_links:
        weight = robot.compensation.qfrc_gravcomp[robot.dofs]
    robot.motor[joints] += (values["factor"] - 1) * weight[joints]
