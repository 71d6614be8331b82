"""A back end of one's own: joints that follow their commands a little late, whatever the gains."""

import numpy as np
from pydantic import Field

from t2l.hardware import Backend, Features, State
from t2l.hardware.features import POSITION, VELOCITY
from t2l.typed import Number, Typed


class Settings(Typed):
    """What a configuration may write under `robot`."""

    lag_s: Number = Field(0.05, gt=0, description="time constant of the joints, s")


class Echo(Backend):
    """q̇ = (q_des − q) / lag."""

    name = "echo"
    settings = Settings

    def __init__(self, robot, settings, n):
        self.robot, self.n, self.lag_s = robot, n, settings.lag_s
        self.can = self.features(robot, settings)
        self.notes = f"an echo after {settings.lag_s} s"

    @classmethod
    def features(cls, robot, settings):
        # it measures no torque, and has room for two robots
        return Features(control_rate_hz=1000, signals=(POSITION, VELOCITY), side_by_side=2)

    @classmethod
    def open(cls, robot, settings, n=1):
        return cls(robot, settings, n)

    def start(self, q, kp, kd):
        self.q = np.broadcast_to(q, (self.n, len(self.robot.joints))).copy()
        self.dq = np.zeros_like(self.q)
        return self.read()

    def send(self, q_des, period_s):
        step = (q_des - self.q) * (1 - np.exp(-period_s / self.lag_s))
        self.q, self.dq = self.q + step, step / period_s

    def read(self):
        return State(self.q.copy(), self.dq.copy())

    def hold(self):
        self.dq[:] = 0

    def close(self):
        """A robot of metal is stopped and released here."""
