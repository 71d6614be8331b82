"""A back end of a user's own, in a file outside the package, and what it takes to deploy to it."""

import numpy as np

from t2l.policies import Policy

# joints that follow commands as a first-order lag, whatever the robot
FOLLOWER = """
import numpy as np
from t2l.hardware import Backend, BackendError, Features, State
from t2l.hardware.features import POSITION, VELOCITY
from t2l.typed import Number, Typed


class Settings(Typed):
    lag_s: Number = 0.1
    fails_after_s: Number | None = None


class Follower(Backend):
    name = "follower"
    settings = Settings

    def __init__(self, robot, settings, n):
        self.robot, self.n, self.own, self.closed = robot, n, settings, False
        self.can = self.features(robot, settings)
        self.notes = f"a lag of {settings.lag_s} s"

    @classmethod
    def features(cls, robot, settings):
        return Features(control_rate_hz=1000.0, signals=(POSITION, VELOCITY), side_by_side=2)

    @classmethod
    def open(cls, robot, settings, n=1):
        return cls(robot, settings, n)

    def start(self, q, kp, kd):
        self.q = np.broadcast_to(q, (self.n, len(self.robot.joints))).copy()
        self.dq = np.zeros_like(self.q)
        self.time = 0.0
        return self.read()

    def send(self, q_des, period_s):
        self.time += period_s
        if self.own.fails_after_s and self.time > self.own.fails_after_s:
            raise BackendError("found no answer; allowed: an answer within a second")
        step = (q_des - self.q) * (1 - np.exp(-period_s / self.own.lag_s))
        self.q, self.dq = self.q + step, step / period_s

    def read(self):
        return State(self.q.copy(), self.dq.copy())

    def hold(self):
        self.dq[:] = 0

    def close(self):
        self.closed = True
"""


class Proportional(Policy):
    """Moves every joint by `gain` times what is left to do."""

    name = "proportional"
    history = chunk = 1

    def __init__(self, njoint: int, gain: float = 3.0):
        self.observation_size, self.action_size, self.gain = 4 * njoint, njoint, gain

    def act(self, history: np.ndarray) -> np.ndarray:
        left = history[:, -1:, 2 * self.action_size : 3 * self.action_size]
        return np.clip(self.gain * left, -1, 1)

    def tensors(self):
        return {"gain": np.array(self.gain)}

    def metadata(self):
        return {"action_size": self.action_size}

    @classmethod
    def restored(cls, tensors, metadata):
        return cls(metadata["action_size"], float(tensors["gain"]))
