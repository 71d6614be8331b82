"""The identified simulator in a robot's place, so that both go through the same deployment."""

import numpy as np

from t2l.hardware.backend import Backend, State
from t2l.identify.actuator_parameters import Parameters
from t2l.identify.training_simulator import Simulator
from t2l.robots import Robot
from t2l.robots.plant import position_controlled
from t2l.sim.controllers.joint_pd import pd_torque


class IdentifiedRobot(Backend):
    """`n` robots with parameters (njoint,) of a cell."""

    def __init__(self, robot: Robot, n: int, parameters: Parameters, rate_hz: float):
        self.n, self.control_rate_hz = n, rate_hz
        self._simulator = Simulator(robot, position_controlled(robot), n, rate_hz)
        self._simulator.set_parameters(parameters)

    def start(self, q: np.ndarray, kp: np.ndarray, kd: np.ndarray) -> State:
        """See `Backend.start`; the gains only tell what torque the controller would send."""
        self._kp, self._kd = kp, kd
        self._simulator.batch.reset()
        self._simulator.qpos[:] = q
        return self._state(self._simulator.qpos)

    def step(self, q_des: np.ndarray, period_s: float) -> State:
        """See `Backend.step`."""
        self._simulator.step(q_des, round(period_s * self.control_rate_hz))
        return self._state(q_des)

    def hold(self) -> None:
        """Nothing to brake."""

    def close(self) -> None:
        """Nothing to release."""

    def _state(self, q_des: np.ndarray) -> State:
        q, dq = self._simulator.qpos.copy(), self._simulator.qvel.copy()
        return State(q, dq, pd_torque(q_des, q, dq, self._kp, self._kd))
