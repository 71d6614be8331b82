"""Joint reaching as most people would write it: a gymnasium environment that steps one MjData."""

import gymnasium as gym
import mujoco
import numpy as np

from t2l.environment.interface import action_space, observe, scale_per_joint
from t2l.environment.limits import NAMES, Limits, violations
from t2l.sim.controllers.joint_pd import pd_torque
from t2l.sim.training_simulator import AT_REST_RAD_S
from t2l.tasks.terms import Moment


class GymnasiumReach(gym.Env):
    """The same task, simulator, reward and constraints as `Environments` of one arm."""

    def __init__(self, problem, choice, seed: int):
        self.task, self.cell = problem.task, problem.cell
        self.robot = self.task.robot
        scale = scale_per_joint(choice.action_scale, self.robot)
        self.actions = action_space(problem.condition.actions, self.robot, scale)
        spec = self.task.spec(visual=False)
        spec.option.timestep = 1 / problem.rate_hz
        self.model = spec.compile()
        p = problem.parameters
        self.model.actuator_gainprm[:, 0] = p["stiffness"]
        self.model.actuator_biasprm[:, 1] = -p["stiffness"]
        self.model.actuator_biasprm[:, 2] = -p["damping"]
        self.model.dof_armature[:] = p["armature"]
        self.model.dof_damping[:] = p["viscous_friction"]
        self.static = p["static_friction"]
        self.dynamic = self.static * p["dynamic_friction_ratio"]
        self.data = mujoco.MjData(self.model)
        mujoco.mj_setConst(self.model, self.data)
        self.nstep = round(problem.rate_hz / problem.condition.policy_rate_hz)
        self.period_s = 1 / problem.condition.policy_rate_hz
        self.horizon = round(problem.horizon_s / self.period_s)
        self.generator = np.random.default_rng(seed)
        self.limits = Limits.of(self.robot, 1 / problem.rate_hz)
        njoint = len(self.robot.joints)
        self.observation_space = gym.spaces.Box(-np.inf, np.inf, (4 * njoint,), np.float32)
        self.action_space = gym.spaces.Box(-1.0, 1.0, (njoint,), np.float32)

    def reset(self, *, seed=None, options=None):
        """See `gymnasium.Env`."""
        mujoco.mj_resetData(self.model, self.data)
        self.data.qpos[:] = self.task.sample_starts(self.generator, 1)[0]
        self.goal = self.task.sample_goals(self.generator, 1)
        self.action, self.torque = np.zeros((2, 1, len(self.robot.joints)))
        self.elapsed, self.violated = 0, np.zeros(len(NAMES))
        self.before = self.goal - self.data.qpos
        return self._observe(self.before), {}

    def step(self, action):
        """See `gymnasium.Env`."""
        action = np.clip(action, -1, 1)[None]
        change, self.action = action - self.action, action
        q_des = self.actions.command(action, self.data.qpos[None], None)
        for _ in range(self.nstep):
            q, dq = self.data.qpos[None], self.data.qvel[None]
            torque = pd_torque(q_des, q, dq, self.cell.kp, self.cell.kd)
            self.violated += violations(q, dq, torque, self.torque, self.limits)[0]
            self.torque = torque
            moving = np.abs(self.data.qvel) > AT_REST_RAD_S
            self.model.dof_frictionloss[:] = np.where(moving, self.dynamic, self.static)
            self.data.ctrl[:] = q_des[0]
            mujoco.mj_step(self.model, self.data)
        errors = self.goal - self.data.qpos
        reward = sum(self.task.paid(self._moment(errors, change)))
        self.before, self.elapsed = errors, self.elapsed + 1
        return self._observe(errors), float(reward[0]), False, self.elapsed >= self.horizon, {}

    def _moment(self, errors, change=None):
        return Moment(
            self.task, None, self.data.qpos[None], self.data.qvel[None], self.goal, errors,
            self.before, self.action, change, self.period_s,
        )  # fmt: skip

    def _observe(self, errors):
        return observe(self._moment(errors), np.zeros((1, 0)))[0]
