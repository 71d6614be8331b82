"""The identified simulator in a robot's place, so that both go through the same deployment."""

import numpy as np

from t2l.hardware.backend import PositionControlled
from t2l.hardware.features import State
from t2l.robots import Robot
from t2l.robots.plant import position_controlled
from t2l.sim.controllers.joint_pd import pd_torque
from t2l.sim.training_simulator import Parameters, Simulator


class IdentifiedRobot(PositionControlled):
    """`n` robots with parameters (njoint,) of a cell."""

    def __init__(self, robot: Robot, n: int, parameters: Parameters, rate_hz: float):
        self.n, self._rate_hz = n, rate_hz
        self._simulator = Simulator(
            position_controlled(robot), robot.joints, robot.torque_limit, n, rate_hz
        )
        self._simulator.set_parameters(parameters)

    def start(self, q: np.ndarray, kp: np.ndarray, kd: np.ndarray) -> State:
        """See `PositionControlled.start`; the gains only tell what the controller would send."""
        self._kp, self._kd = kp, kd
        self._simulator.batch.reset()
        self._simulator.put(q)
        self._q_des = self._simulator.q.copy()
        return self.read()

    def send(self, q_des: np.ndarray, period_s: float) -> None:
        """See `PositionControlled.send`."""
        self._simulator.step(q_des, round(period_s * self._rate_hz))
        self._q_des = q_des

    @property
    def watched_hz(self) -> float:
        """See `PositionControlled.watched_hz`: at each step."""
        return self._rate_hz

    def hold(self) -> None:
        """Nothing to brake."""

    def close(self) -> None:
        """Nothing to release."""

    def read(self) -> State:
        """See `PositionControlled.read`."""
        q, dq = self._simulator.q.copy(), self._simulator.dq.copy()
        return State(q, dq, pd_torque(self._q_des, q, dq, self._kp, self._kd))
