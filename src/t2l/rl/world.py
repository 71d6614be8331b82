"""Robots at a task, each with a goal of its own, stepping together.

Arrays are NumPy's, or torch's where the simulations run on a GPU. One world may hold several
trainings side by side, each with as many robots: what differs between them has a row a robot.
"""

from collections.abc import Sequence
from typing import NamedTuple

import mujoco
import numpy as np

from t2l.actions import ActionSpace
from t2l.identify.actuator_parameters import Parameters
from t2l.identify.training_simulator import Simulator
from t2l.rl.constraints import JITTER_RAD_S, JITTER_WINDOW_S, LIMITS, Limits, violations
from t2l.rl.interface import observe, steps_held
from t2l.sim.arrays import Array, like, namespace, to_numpy
from t2l.sim.batch import MUJOCO
from t2l.sim.controllers.joint_pd import pd_torque
from t2l.tasks import Rewarded

STAGGER = 10  # steps between instants at which episodes end: resets are dear one by one
# actions are not clipped at it: stable-baselines3 takes no infinite bounds
UNBOUNDED = 100.0


class Ended(NamedTuple):
    """Episodes that end with a step.

    Attributes:
        ids: (k,) which robots', ascending.
        observation: (k, nobs) the last of each.
        success: (k,) bool, at the goal without jitter.
        violated: (k, nname) bool, in order of `t2l.rl.constraints.NAMES`.
    """

    ids: np.ndarray
    observation: Array
    success: np.ndarray
    violated: np.ndarray


class World:
    """`n` robots for each generator; rows of arrays go by generator, then by robot.

    An episode has a fixed length. Episodes begin at random points of their length if they are
    `staggered`, so that they do not all end at once.

    Args:
        kp, kd: that the robot's own controller is given, one number or (rows, 1).
        parameters: of the identified simulator, each broadcasting to (rows, njoint).
        actions: what actions mean; `scale` may have a row a robot.
        generators: of starts, goals and noise, one a training.
        n: robots of each.
        staggered: whether first episodes begin at random points of their length.
        clipped: whether actions are clipped to [-1, 1].
        noise: uniform, up to so many rad and rad/s, on the q and q̇ that are observed.
        device: of the simulations.

    Attributes:
        disturbance: what else acts on the robots, the task's; another one may take its place.

    Raises:
        ConfigurationError: the policy's rate does not divide the simulator's.
    """

    def __init__(
        self,
        task: Rewarded,
        kp: np.ndarray | float,
        kd: np.ndarray | float,
        parameters: Parameters,
        actions: ActionSpace,
        generators: Sequence[np.random.Generator],
        n: int,
        horizon_s: float,
        policy_rate_hz: float,
        rate_hz: float,
        threads: int = 1,
        staggered: bool = True,
        clipped: bool = True,
        noise: tuple[float, float] = (0.0, 0.0),
        device: str = MUJOCO,
    ):
        self.task, self.each = task, n
        self.generators, self.rows = list(generators), n * len(generators)
        self.nstep = steps_held(rate_hz, policy_rate_hz, "the simulator's")
        self.horizon = round(horizon_s * policy_rate_hz)
        spec = task.spec(visual=False)
        self.simulator = Simulator(task.robot, spec, self.rows, rate_hz, threads, device)
        self.simulator.set_parameters(parameters)
        self.disturbance = task.disturbance(self.simulator.batch, self.generators[0])
        self.staggered, self._noise = staggered, noise
        self.bound = 1.0 if clipped else UNBOUNDED
        self.period_s = 1 / policy_rate_hz
        self.actions = actions.like(self.simulator.qpos)
        self._kp, self._kd = (self.array(gain) for gain in (kp, kd))
        self._limits = Limits.of(task.robot, self.simulator.timestep_s).like(self.simulator.qpos)
        self._goal = self._zeros(task.goal_size)
        # the same twice: what is on the device need not wait for what is not
        self._elapsed, self._age = np.zeros(self.rows, int), self._zeros(1)
        self._action = self._zeros(len(actions.names))
        self._command = self.simulator.qpos + 0.0
        self._torque = 0.0 * self._command
        self._violated = self.array(np.zeros((self.rows, len(LIMITS)), bool))
        # of the velocities over the end of an episode: their number, sum and sum of squares
        self._settling = max(0, self.horizon - round(JITTER_WINDOW_S * policy_rate_hz))
        self._moments = self.array(np.zeros((2, *self._command.shape)))
        self.observation_size = self._observe(self._begin(np.arange(self.rows))).shape[1]

    def begin(self) -> Array:
        """Begin every episode anew; (rows, nobs) what is seen."""
        remaining = self._begin(np.arange(self.rows))
        if self.staggered:
            phases = max(1, self.horizon // STAGGER)
            drawn = [STAGGER * g.integers(0, phases, self.each) for g in self.generators]
            self._put_at(np.arange(self.rows), np.concatenate(drawn))
        return self._observe(remaining)

    def place(self, q: Array, goal: Array) -> Array:
        """Begin every episode at given starts (rows, njoint) and goals (rows, goal_size)."""
        return self._observe(self._begin(np.arange(self.rows), q, goal))

    def advance(self, action: Array) -> tuple[Array, Array, Ended]:
        """Hold actions (rows, naction) for a policy period.

        Returns:
            What is seen then (rows, nobs), of new episodes where some ended; what the step was
            worth (rows,); and the episodes that ended.
        """
        xp = namespace(self._action)
        action = xp.clip(self.array(action), -self.bound, self.bound)
        change, self._action = action - self._action, action
        self._command = self.actions.command(action, self.simulator.qpos, self._command)
        if self.disturbance is not None:
            self.disturbance.apply(self._elapsed * self.period_s)
        self._advance(self._command)
        before, remaining = self._before, self._remaining()
        reward = self.task.reward(before, remaining, self.period_s, self.simulator.qvel, change)
        self._before = remaining
        self._elapsed += 1
        self._age += 1
        ids = np.flatnonzero(self._elapsed >= self.horizon)
        observation = self._observe(remaining)
        if not ids.size:
            none = np.zeros((0, len(LIMITS) + 1), bool)
            return observation, reward, Ended(ids, observation[:0], none[:, 0], none)
        jitters = to_numpy(self._jitter() > JITTER_RAD_S)[ids]
        ended = Ended(
            ids,
            xp.asarray(observation[ids], copy=True),
            to_numpy(self.task.success(remaining))[ids] & ~jitters,
            np.column_stack([to_numpy(self._violated)[ids], jitters]),
        )
        observation = xp.asarray(observation, copy=True)
        observation[ids] = self._observe(self._begin(ids))[ids]
        return observation, reward, ended

    def _advance(self, q_des: Array) -> None:
        simulator, xp = self.simulator, namespace(q_des)
        settling = self._age >= self._settling
        for _ in range(self.nstep):
            # what the robot's own controller would ask for, with the gains it is given
            torque = pd_torque(q_des, simulator.qpos, simulator.qvel, self._kp, self._kd)
            self._violated |= violations(
                simulator.qpos, simulator.qvel, torque, self._torque, self._limits
            )
            self._torque = torque
            simulator.step(q_des, 1)
            self._moments += settling * xp.stack([simulator.qvel, simulator.qvel**2])

    def _jitter(self) -> Array:
        """Of episodes at their end, as `t2l.rl.constraints.jitter` has it, (rows,) rad/s."""
        mean, square = self._moments / ((self.horizon - self._settling) * self.nstep)
        xp = namespace(mean)
        return xp.max(xp.sqrt(xp.clip(square - mean**2, 0.0, None)), axis=1)

    def _begin(self, ids: np.ndarray, q: Array | None = None, goal: Array | None = None) -> Array:
        """Put robots `ids` at a start at rest with a goal; what remains to all."""
        simulator, task = self.simulator, self.task
        simulator.batch.reset(ids=ids, stage=mujoco.mjtStage.mjSTAGE_NONE.value)
        simulator.qpos[ids] = self.array(self._drawn(task.sample_starts, ids) if q is None else q)
        self._goal[ids] = self.array(self._drawn(task.sample_goals, ids) if goal is None else goal)
        self._put_at(ids, np.zeros(len(ids), int))
        self._action[ids] = 0.0
        self._command[ids] = simulator.qpos[ids]
        self._torque[ids] = 0.0
        self._violated[ids] = False
        self._moments[:, ids] = 0.0
        if self.disturbance is not None:
            self.disturbance.begin(ids)
        self._before = self._remaining()
        return self._before

    def _put_at(self, ids: np.ndarray, step: np.ndarray) -> None:
        """Let robots `ids` be at steps (k,) of their episodes."""
        self._elapsed[ids] = step
        self._age[ids] = self.array(step[:, None])

    def _drawn(self, sample, ids: np.ndarray) -> np.ndarray:
        """A sample for each of `ids`, each training's from its own generator."""
        counts = np.bincount(ids // self.each, minlength=len(self.generators))
        drawn = [sample(g, k) for g, k in zip(self.generators, counts, strict=True) if k]
        return np.concatenate(drawn) if len(drawn) > 1 else drawn[0]

    def _remaining(self) -> Array:
        return self.task.remaining(self.simulator.batch, self._goal)

    def _observe(self, remaining: Array) -> Array:
        q, dq = self.simulator.qpos, self.simulator.qvel
        if not any(self._noise):
            return self._seen(q, dq, remaining)
        noise_q, noise_dq = (self._uniform(most, q) for most in self._noise)
        return self.observed_at(q + noise_q, dq + noise_dq)

    def _uniform(self, most: float, like_q: Array) -> Array:
        """Noise up to `most` either way, of the shape of positions."""
        shape = (self.each, like_q.shape[1])
        if isinstance(like_q, np.ndarray):
            drawn = [g.uniform(-most, most, shape) for g in self.generators]
            return np.concatenate(drawn) if len(drawn) > 1 else drawn[0]
        # drawn on the device, which is seeded by who trains
        return 2 * most * (like_q.new_empty(like_q.shape).uniform_() - 0.5)

    def observed_at(self, q: Array, dq: Array) -> Array:
        """What a policy would see if the joints were at q with dq, (rows, njoint) each.

        What remains to the goal follows from q, as it does on a robot.
        """
        xp = namespace(q)
        true = xp.asarray(self.simulator.qpos, copy=True)
        self.simulator.qpos[...] = q
        remaining = self._remaining()
        self.simulator.qpos[...] = true
        return self._seen(q, dq, remaining)

    def _seen(self, q: Array, dq: Array, remaining: Array) -> Array:
        memory = self.actions.memory(q, self._command)
        return observe(q, dq, remaining, self._action, memory)

    def array(self, values: Array) -> Array:
        """Numbers, or truth values, as an array of this world."""
        return like(values, self.simulator.qpos)

    def _zeros(self, columns: int) -> Array:
        return self.array(np.zeros((self.rows, columns)))
