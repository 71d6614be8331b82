"""A task as a stable-baselines3 VecEnv: all environments are one batch of simulations.

An action becomes a command by the condition's action space; the command is held for a policy
period.
"""

from collections.abc import Mapping
from typing import Any

import mujoco
import numpy as np
from gymnasium import spaces
from stable_baselines3.common.vec_env import VecEnv

from t2l.actions import ActionSpace
from t2l.gains import Cell
from t2l.identify.actuator_parameters import Parameters
from t2l.identify.training_simulator import Simulator
from t2l.rl.constraints import (
    JITTER_RAD_S,
    JITTER_WINDOW_S,
    LIMITS,
    NAMES,
    violations,
)
from t2l.rl.interface import observe, steps_held
from t2l.sim.controllers.joint_pd import pd_torque
from t2l.tasks import Rewarded

STAGGER = 10  # steps between instants at which episodes end: resets are dear one by one
# actions are not clipped at it: stable-baselines3 takes no infinite bounds
UNBOUNDED = 100.0


class Environments(VecEnv):
    """`n` robots at a task, each with a goal of its own.

    An episode has a fixed length and ends by truncation. Episodes begin at random points of
    their length, so that they do not all end at once. The info of an episode that ends holds
    `success`, at the goal without jitter, and by the name of each constraint whether the episode
    violated it.

    Attributes:
        disturbance: what else acts on the robots, the task's; another one may take its place.
    """

    def __init__(
        self,
        task: Rewarded,
        cell: Cell,
        parameters: Parameters,
        actions: ActionSpace,
        n: int,
        seed: int,
        horizon_s: float,
        policy_rate_hz: float,
        rate_hz: float,
        threads: int = 1,
        randomisation: float = 0.0,
        staggered: bool = True,
        clipped: bool = True,
        noise: tuple[float, float] = (0.0, 0.0),
    ):
        """See the class.

        Args:
            parameters: of the identified simulator, (njoint,) each.
            actions: what actions mean.
            randomisation: each environment's parameters differ by up to this fraction.
            staggered: whether first episodes begin at random points of their length.
            clipped: whether actions are clipped to [-1, 1].
            noise: uniform, up to so many rad and rad/s, on the q and q̇ that are observed.

        Raises:
            ConfigurationError: the policy's rate does not divide the simulator's.
        """
        self.task, self.cell, self.actions = task, cell, actions
        self.nstep = steps_held(rate_hz, policy_rate_hz, "the simulator's")
        self.horizon = round(horizon_s * policy_rate_hz)
        self.generator = np.random.default_rng(seed)
        self.simulator = Simulator(task.robot, task.spec(visual=False), n, rate_hz, threads)
        self.simulator.set_parameters(_randomised(parameters, n, randomisation, self.generator))
        self.disturbance = task.disturbance(self.simulator.batch, self.generator)
        self.staggered, self._noise = staggered, noise
        self._bound = 1.0 if clipped else UNBOUNDED
        self.render_mode = None
        self._infos: list[dict[str, Any]] = [{} for _ in range(n)]
        self.period_s = 1 / policy_rate_hz
        self._goal = np.zeros((n, task.goal_size))
        self._elapsed = np.zeros(n, int)
        self._action = np.zeros((n, len(actions.names)))
        self._command = self.simulator.qpos.copy()
        self._torque = np.zeros_like(self._command)
        self._violated = np.zeros((n, len(LIMITS)), bool)
        # of the velocities over the end of an episode: their number, sum and sum of squares
        self._settling = max(0, self.horizon - round(JITTER_WINDOW_S * policy_rate_hz))
        self._moments = np.zeros((2, *self._command.shape))
        size = self._observe(self._begin(np.arange(n))).shape[1]
        super().__init__(
            n,
            spaces.Box(-np.inf, np.inf, (size,), np.float32),
            spaces.Box(-self._bound, self._bound, (len(actions.names),), np.float32),
        )

    def reset(self) -> np.ndarray:
        """Begin every episode anew."""
        remaining = self._begin(np.arange(self.num_envs))
        if self.staggered:
            phases = max(1, self.horizon // STAGGER)
            self._elapsed = STAGGER * self.generator.integers(0, phases, self.num_envs)
        return self._observe(remaining)

    def place(self, q: np.ndarray, goal: np.ndarray) -> np.ndarray:
        """Begin every episode at given starts (n, njoint) and goals (n, goal_size)."""
        return self._observe(self._begin(np.arange(self.num_envs), q, goal))

    def step_async(self, actions: np.ndarray) -> None:
        """See `VecEnv`."""
        self._next = np.clip(actions, -self._bound, self._bound)

    def step_wait(self) -> tuple[np.ndarray, np.ndarray, np.ndarray, list[dict[str, Any]]]:
        """See `VecEnv`."""
        change, self._action = self._next - self._action, self._next
        self._command = self.actions.command(self._action, self.simulator.qpos, self._command)
        if self.disturbance is not None:
            self.disturbance.apply(self._elapsed * self.period_s)
        self._advance(self._command)
        before, remaining = self._before, self._remaining()
        reward = self.task.reward(before, remaining, self.period_s, self.simulator.qvel, change)
        self._before = remaining
        self._elapsed += 1
        done = self._elapsed >= self.horizon
        observation = self._observe(remaining)
        infos = self._infos
        if done.any():
            ended = np.flatnonzero(done)
            infos = list(self._infos)
            jitters = self._jitter() > JITTER_RAD_S
            success = self.task.success(remaining) & ~jitters
            violated = np.column_stack([self._violated, jitters])
            for i in ended:
                infos[i] = {
                    "terminal_observation": observation[i],
                    "TimeLimit.truncated": True,
                    "success": bool(success[i]),
                    **dict(zip(NAMES, violated[i].tolist(), strict=True)),
                }
            observation = observation.copy()
            observation[ended] = self._observe(self._begin(ended))[ended]
        return observation, reward.astype(np.float32), done, infos

    def _advance(self, q_des: np.ndarray) -> None:
        simulator, period = self.simulator, self.simulator.timestep_s
        for _ in range(self.nstep):
            # what the robot's own controller would ask for, with the gains it is given
            torque = pd_torque(q_des, simulator.qpos, simulator.qvel, self.cell.kp, self.cell.kd)
            self._violated |= violations(
                simulator.qpos, simulator.qvel, torque, self._torque, period, simulator.robot
            )
            self._torque = torque
            simulator.step(q_des, 1)
            settling = (self._elapsed >= self._settling)[:, None]
            self._moments += settling * np.stack([simulator.qvel, simulator.qvel**2])

    def _jitter(self) -> np.ndarray:
        """Of episodes at their end, as `t2l.rl.constraints.jitter` has it, (n,) rad/s."""
        mean, square = self._moments / ((self.horizon - self._settling) * self.nstep)
        return np.sqrt(np.maximum(square - mean**2, 0.0)).max(axis=1)

    def _begin(
        self, ids: np.ndarray, q: np.ndarray | None = None, goal: np.ndarray | None = None
    ) -> np.ndarray:
        """Put environments `ids` at a start at rest with a goal; what remains to all."""
        simulator, task = self.simulator, self.task
        simulator.batch.reset(ids=ids, stage=mujoco.mjtStage.mjSTAGE_NONE.value)
        simulator.qpos[ids] = task.sample_starts(self.generator, len(ids)) if q is None else q
        self._goal[ids] = task.sample_goals(self.generator, len(ids)) if goal is None else goal
        self._elapsed[ids] = 0
        self._action[ids] = 0.0
        self._command[ids] = simulator.qpos[ids]
        self._torque[ids] = 0.0
        self._violated[ids] = False
        self._moments[:, ids] = 0.0
        if self.disturbance is not None:
            self.disturbance.begin(ids)
        self._before = self._remaining()
        return self._before

    def _remaining(self) -> np.ndarray:
        return self.task.remaining(self.simulator.batch, self._goal)

    def _observe(self, remaining: np.ndarray) -> np.ndarray:
        q, dq = self.simulator.qpos, self.simulator.qvel
        if not any(self._noise):
            return self._seen(q, dq, remaining)
        noise_q, noise_dq = (self.generator.uniform(-a, a, q.shape) for a in self._noise)
        return self.observed_at(q + noise_q, dq + noise_dq)

    def observed_at(self, q: np.ndarray, dq: np.ndarray) -> np.ndarray:
        """What a policy would see if the joints were at q with dq, (n, njoint) each.

        What remains to the goal follows from q, as it does on a robot.
        """
        true = self.simulator.qpos.copy()
        self.simulator.qpos[:] = q
        remaining = self._remaining()
        self.simulator.qpos[:] = true
        return self._seen(q, dq, remaining)

    def _seen(self, q: np.ndarray, dq: np.ndarray, remaining: np.ndarray) -> np.ndarray:
        memory = self.actions.memory(q, self._command)
        return observe(q, dq, remaining, self._action, memory)

    def close(self) -> None:
        """Nothing to release."""

    def get_attr(self, attr_name: str, indices=None) -> list[Any]:
        """See `VecEnv`; the environments share their attributes."""
        return [getattr(self, attr_name)] * len(list(self._get_indices(indices)))

    def set_attr(self, attr_name: str, value: Any, indices=None) -> None:
        """See `VecEnv`."""
        raise AttributeError("the environments of a batch share their attributes")

    def env_method(self, method_name: str, *method_args, indices=None, **method_kwargs):
        """See `VecEnv`."""
        raise AttributeError("the environments of a batch have no methods of their own")

    def env_is_wrapped(self, wrapper_class, indices=None) -> list[bool]:
        """See `VecEnv`."""
        return [False] * len(list(self._get_indices(indices)))


def _randomised(
    parameters: Mapping[str, np.ndarray],
    n: int,
    fraction: float,
    generator: np.random.Generator,
) -> Parameters:
    """Parameters (n, njoint), each up to `fraction` more or less."""
    return {
        name: values * generator.uniform(1 - fraction, 1 + fraction, (n, len(values)))
        for name, values in parameters.items()
    }
