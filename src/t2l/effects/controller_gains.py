"""Gains that are not what the log says."""

import numpy as np

from t2l.effects.effect import Effect, Parameter


class ControllerGains(Effect):
    """Kp → a Kp, Kd → b Kd."""

    name = "controller_gains"
    title = "wrong controller gains"
    parameters = (
        Parameter("kp_factor", "1", 0.1, 10.0, "real over logged Kp", neutral=1.0, log=True),
        Parameter("kd_factor", "1", 0.05, 20.0, "real over logged Kd", neutral=1.0, log=True),
    )
    summary = "the controller's stiffness and damping are not those in the log"
    signature = "the error follows the position error and the velocity, in proportion to the gains"
    source = "τ = a Kp (q_des − q) − b Kd q̇"
    acts_through = ("kp", "kd")
    remembers = False
    follows = "torque"

    def export(self, to, joints, values):
        to.kp[joints] *= values["kp_factor"]
        to.kd[joints] *= values["kd_factor"]

    def install(self, loop, rows, joints, values):
        loop.kp[rows, joints] *= values["kp_factor"]
        loop.kd[rows, joints] *= values["kd_factor"]

    def starts(self, scales):
        one = np.ones_like(scales.torque)
        return [
            {"kp_factor": p * one, "kd_factor": d * one}
            for p, d in ((0.95, 1.0), (0.7, 1.0), (1.3, 1.0), (1.0, 0.7), (1.0, 1.4))
        ]
