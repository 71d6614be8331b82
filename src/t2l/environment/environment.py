"""Robots at a task, each with a goal of its own, stepping together.

Arrays are NumPy's, or torch's where the simulations run on a GPU. One environment may hold several
trainings side by side, each with as many robots: what differs between them has a row a robot.

    environment = Environment(task, kp, kd, parameters, actions, [generator], n=512, ...)
    observation = environment.begin()
    while True:
        observation, reward, ended = environment.advance(policy(observation))
"""

import json
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from array_api_compat import is_array_api_obj

from t2l.actions import ActionSpace
from t2l.actions.gripper import BinaryGrippers
from t2l.environment.interface import observe, steps_held
from t2l.environment.limits import JITTER_RAD_S, JITTER_WINDOW_S, LIMITS, Limits, violations
from t2l.environment.starts import check_starts
from t2l.errors import ConfigurationError
from t2l.sim.arrays import Array, like, namespace, to_numpy
from t2l.sim.batch import MUJOCO, diverged
from t2l.sim.controllers.joint_pd import pd_torque
from t2l.sim.training_simulator import Parameters, Simulator
from t2l.tasks import Rewarded
from t2l.tasks.terms import Moment

# what a step changes besides the simulations, a row a robot or a training
CHANGING = (
    "_goal", "_elapsed", "_age", "_action", "_command", "_torque", "_violated", "_moments",
    "_effort", "_paid",
)  # fmt: skip
STAGGER = 10  # steps between instants at which episodes end: resets are dear one by one
# actions are not clipped at it: stable-baselines3 takes no infinite bounds
UNBOUNDED = 100.0
NOBODY = np.zeros(0, int)


class Ended(NamedTuple):
    """Episodes that end with a step.

    Attributes:
        ids: (k,) which robots', ascending.
        observation: (k, nobs) the last of each.
        success: (k,) bool.
        violated: (k, nname) bool, in order of `t2l.environment.limits.NAMES`.
        failed: (k,) bool, ended before its time by one of the task's terminations, or because its
            simulation diverged.
        jitter: (k,) rad/s, see `t2l.environment.limits.jitter`.
        effort: (k,) torque that was asked for over the torque limit, its RMS over time and joints.
    """

    ids: np.ndarray
    observation: Array
    success: np.ndarray
    violated: np.ndarray
    failed: np.ndarray
    jitter: np.ndarray
    effort: np.ndarray


class Environment:
    """`n` robots for each generator; rows of arrays go by generator, then by robot.

    An episode has a fixed length, unless a termination of the task or a simulation that diverges
    ends it before. Episodes begin at random points of their length if they are `staggered`, so that
    they do not all end at once.

    Args:
        kp, kd: of the cell, that the robot's own controller is given, one number or (rows, 1).
        parameters: of the simulator, each broadcasting to (rows, njoint).
        actions: what actions mean to the joints; `scale` may have a row a robot. The last elements
            of an action are the grippers', see `t2l.actions.gripper`.
        generators: of starts, goals and noise, one a training.
        n: robots of each.
        rate_hz: of the physics.
        staggered: whether first episodes begin at random points of their length.
        clipped: whether actions are clipped to [-1, 1].
        noise: uniform, up to so many rad and rad/s, on the q and q̇ that are observed.
        device: of the simulations.
        simulator: of all robots, in place of the training simulator, such as a
            `t2l.rl.twin.Twin`; then `parameters` are not used.

    Attributes:
        action_names: of the elements of an action.
        steps: of a training, those of all its robots.
        disturbance: what else acts on the robots, the task's; another one may take its place.

    Raises:
        ConfigurationError: the policy's rate does not divide the simulator's, or this is too low
            for the task; something starts inside something else; the device cannot simulate it.
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
        simulator: Any = None,
    ):
        self.task, self.each = task, n
        self.generators, self.rows = list(generators), n * len(generators)
        if rate_hz < task.least_rate_hz:
            raise ConfigurationError(
                f"rate of the physics: found {rate_hz:g} Hz; allowed: from {task.least_rate_hz:g} "
                f"Hz, at which the contacts of {task.name} hold"
            )
        check_starts(task)
        self.nstep = steps_held(rate_hz, policy_rate_hz, "the simulator's")
        self.horizon = round(horizon_s * policy_rate_hz)
        if simulator is None:
            simulator = Simulator(
                task.spec(visual=False), task.robot.joints, task.robot.torque_limit,
                self.rows, rate_hz, threads, device,
            )  # fmt: skip
            simulator.set_parameters(parameters)
        self.simulator = simulator
        self.disturbance = task.disturbance(self.simulator.batch, self.generators[0])
        self.staggered, self._noise = staggered, noise
        self.bound = 1.0 if clipped else UNBOUNDED
        self.period_s = 1 / policy_rate_hz
        self.actions = actions.like(self.simulator.q)
        self.grippers = BinaryGrippers(task.commanded_grippers)
        self.action_names = (*actions.names, *self.grippers.names)
        self._kp, self._kd = (self.array(gain) for gain in task.robot.gains(kp, kd))
        self._limits = Limits.of(task.robot, self.simulator.timestep_s).like(self.simulator.q)
        self._goal, self._before = self._zeros(task.goal_size), None
        # the same twice: what is on the device need not wait for what is not
        self._elapsed, self._age = np.zeros(self.rows, int), self._zeros(1)
        self._action = self._zeros(len(self.action_names))
        self._command = self.simulator.q + 0.0
        self._torque = 0.0 * self._command
        self._violated = self.array(np.zeros((self.rows, len(LIMITS)), bool))
        # of the velocities over the end of an episode: their number, sum and sum of squares
        self._settling = max(0, self.horizon - round(JITTER_WINDOW_S * policy_rate_hz))
        self._moments = self.array(np.zeros((2, *self._command.shape)))
        # of torques over their limits: the sum over time of the mean square over joints
        self._effort = self._moments[0, :, 0] + 0.0
        self._paid = self.array(np.zeros((len(task.rewards), len(self.generators))))
        self.steps = self._paid_steps = 0
        self.observation_size = self._observe(self._begin(np.arange(self.rows))).shape[1]

    def begin(self) -> Array:
        """Begin every episode anew; (rows, nobs) what is seen."""
        measured = self._begin(np.arange(self.rows))
        if self.staggered:
            phases = max(1, self.horizon // STAGGER)
            drawn = [STAGGER * g.integers(0, phases, self.each) for g in self.generators]
            self._put_at(np.arange(self.rows), np.concatenate(drawn))
        return self._observe(measured)

    def place(self, qpos: Array, goal: Array) -> Array:
        """Begin every episode at given starts (rows, nq) and goals (rows, goal_size)."""
        return self._observe(self._begin(np.arange(self.rows), qpos, goal))

    def state(self) -> dict[str, Any]:
        """All that the steps to come depend on: arrays of NumPy, numbers and text.

        One that was made alike goes on from it, see `restore`. What noise of a device depends on is
        the state of torch, not of this.
        """
        return {
            "own": {name: to_numpy(getattr(self, name)).copy() for name in CHANGING},
            "others": [to_numpy(array).copy() for array in self._others()],
            "generators": [json.dumps(own.bit_generator.state) for own in self.generators],
            "steps": self.steps,
            "paid_steps": self._paid_steps,
        }

    def restore(self, state: Mapping[str, Any]) -> None:
        """Go on from a `state`, whose arrays may be tensors, to the same numbers."""
        for name in CHANGING:
            # not written into what is there: actions have the precision of the policy that acted
            kept = to_numpy(state["own"][name]).copy()
            setattr(self, name, like(kept, getattr(self, name)))
        for array, kept in zip(self._others(), state["others"], strict=True):
            array[:] = like(to_numpy(kept), array)
        for own, kept in zip(self.generators, state["generators"], strict=True):
            own.bit_generator.state = json.loads(kept)
        self.steps, self._paid_steps = state["steps"], state["paid_steps"]

    def advance(self, action: Array) -> tuple[Array, Array, Ended]:
        """Hold actions (rows, naction) for a policy period.

        Returns:
            What is seen then (rows, nobs), of new episodes where some ended; what the step was
            worth (rows,); and the episodes that ended.
        """
        xp = namespace(self._action)
        action = xp.clip(self.array(action), -self.bound, self.bound)
        change, self._action = action - self._action, action
        joints = len(self.actions.names)
        self._command = self.actions.command(action[:, :joints], self.simulator.q, self._command)
        if self.grippers.names:
            opening = self.grippers.command(action[:, joints:])
            self.task.command_grippers(self.simulator.batch.ctrl, opening)
        if self.disturbance is not None:
            self.disturbance.apply(self._elapsed * self.period_s)
        self._advance(self._command)
        at = self._moment(self._measure(self.period_s), change)
        failed, lost = self._failed(at)
        reward = self._pay(at, lost)
        self._before = at.now
        self.steps += self.each
        self._elapsed += 1
        self._age += 1
        ids = np.flatnonzero((self._elapsed >= self.horizon) | failed)
        observation = self._observe(at.now)
        if not ids.size:
            none = np.zeros((0, len(LIMITS) + 1), bool)
            no, nothing = none[:, 0], np.zeros(0)
            return observation, reward, Ended(ids, observation[:0], no, none, no, nothing, nothing)
        observation = xp.asarray(observation, copy=True)
        observation[lost] = 0.0
        jitter, ticks = to_numpy(self._jitter())[ids], self._elapsed[ids] * self.nstep
        jitters = jitter > JITTER_RAD_S
        success = to_numpy(self.task.success(at))[ids] & ~failed[ids]
        ended = Ended(
            ids,
            xp.asarray(observation[ids], copy=True),
            success & ~jitters if self.task.steady else success,
            # of what diverged nothing is known, and the worst is assumed
            np.column_stack([to_numpy(self._violated)[ids], jitters]) | lost[ids, None],
            failed[ids],
            jitter,
            np.sqrt(to_numpy(self._effort)[ids] / np.maximum(1, ticks)),
        )
        observation[ids] = self._observe(self._begin(ids))[ids]
        return observation, reward, ended

    def _others(self) -> list[Array]:
        """What a step changes that is not the environment's own."""
        memory = self.disturbance.memory if self.disturbance is not None else {}
        return [*memory.values(), *_arrays_in((self._before, self.simulator.batch.state))]

    def _advance(self, q_des: Array) -> None:
        simulator, xp = self.simulator, namespace(q_des)
        settling = self._age >= self._settling
        for _ in range(self.nstep):
            # what the robot's own controller would ask for, with the gains it is given
            q, dq = simulator.q, simulator.dq
            torque = pd_torque(q_des, q, dq, self._kp, self._kd)
            self._violated |= violations(q, dq, torque, self._torque, self._limits)
            self._torque = torque
            self._effort += xp.mean((torque / self._limits.torque) ** 2, axis=1)
            simulator.step(q_des, 1)
            self._moments += settling * xp.stack([simulator.dq, simulator.dq**2])

    def _pay(self, at: Moment, lost: np.ndarray) -> Array:
        """What a step is worth (rows,), its terms added to what `paid` tells.

        Args:
            lost: (rows,) bool, who diverged: that is worth nothing, and must not be learned from. A
                training all of whose robots did is paid what is no number, which ends it.
        """
        terms, xp = self.task.paid(at), namespace(at.q)
        if lost.any():
            hopeless = np.repeat(lost.reshape(-1, self.each).all(axis=1), self.each)
            instead = self.array(np.where(hopeless, np.nan, 0.0))
            terms = [xp.where(self.array(lost), instead, term) for term in terms]
        shape = (len(self.generators), self.each)
        self._paid += xp.stack([xp.mean(xp.reshape(term, shape), axis=1) for term in terms])
        self._paid_steps += 1
        reward = terms[0] + 0.0
        for term in terms[1:]:
            reward = reward + term
        return reward

    def paid(self) -> Mapping[str, np.ndarray]:
        """What each term of the reward paid a second since this was asked last, (ngenerator,).

        A mean of weight · value, to be held against the weight; a step pays it times the period.
        """
        means = to_numpy(self._paid) / (max(1, self._paid_steps) * self.period_s)
        self._paid, self._paid_steps = 0.0 * self._paid, 0
        return dict(zip((term.name for term in self.task.rewards), means, strict=True))

    def _failed(self, at: Moment) -> tuple[np.ndarray, np.ndarray]:
        """Whose episodes end as failures, (rows,) bool, and which simulations diverged."""
        failed = lost = diverged(self.simulator.batch)
        for term in self.task.terminations:
            failed = failed | to_numpy(term.value(at))
        return failed, lost

    def _jitter(self) -> Array:
        """Of episodes at their end, as `t2l.environment.limits.jitter` has it, (rows,) rad/s."""
        mean, square = self._moments / ((self.horizon - self._settling) * self.nstep)
        xp = namespace(mean)
        return xp.max(xp.sqrt(xp.clip(square - mean**2, 0.0, None)), axis=1)

    def _begin(self, ids: np.ndarray, qpos: Array | None = None, goal: Array | None = None) -> Any:
        """Put robots `ids` at a start at rest with a goal; what is measured of all."""
        simulator, task = self.simulator, self.task
        batch = simulator.batch
        start = self._drawn(task.sample_starts, ids) if qpos is None else qpos
        simulator.begin(ids, self.array(start))
        if task.robot.grippers:
            batch.ctrl[ids] = self.array(self._hand)
        self._goal[ids] = self.array(self._drawn(task.sample_goals, ids) if goal is None else goal)
        self._put_at(ids, np.zeros(len(ids), int))
        self._action[ids] = 0.0
        self._command[ids] = simulator.q[ids]
        self._torque[ids] = 0.0
        self._violated[ids] = False
        self._moments[:, ids] = 0.0
        self._effort[ids] = 0.0
        if self.disturbance is not None:
            self.disturbance.begin(ids)
        self._before = self._measure(began=ids)
        return self._before

    @property
    def action_scale(self) -> np.ndarray:
        """(rows, naction) α of each element of an action; none acts on those of grippers."""
        scale = to_numpy(self.actions.scale)
        joints = np.broadcast_to(scale, (self.rows, len(self.actions.names)))
        return np.column_stack([joints, np.ones((self.rows, len(self.grippers.names)))])

    @property
    def _hand(self) -> np.ndarray:
        """(nu,) controls at an episode's begin: grippers open, or closed for good."""
        ctrl, task = np.zeros(self.simulator.batch.ctrl.shape[1]), self.task
        closed = [gripper.closed for gripper in task.robot.grippers]
        task.command_grippers(ctrl, closed if task.closed_hand else task.opened)
        return ctrl

    def _put_at(self, ids: np.ndarray, step: np.ndarray) -> None:
        """Let robots `ids` be at steps (k,) of their episodes."""
        self._elapsed[ids] = step
        self._age[ids] = self.array(step[:, None])

    def _drawn(self, sample, ids: np.ndarray) -> np.ndarray:
        """A sample for each of `ids`, each training's from its own generator."""
        counts = np.bincount(ids // self.each, minlength=len(self.generators))
        drawn = [sample(g, k) for g, k in zip(self.generators, counts, strict=True) if k]
        return np.concatenate(drawn) if len(drawn) > 1 else drawn[0]

    def _measure(self, elapsed_s: float = 0.0, began: np.ndarray = NOBODY) -> Any:
        now = self.task.measure(self.simulator.batch, self._goal)
        return self.task.follow(now, self._before, elapsed_s, began)

    def _moment(self, now: Any, change: Array | None = None, **measured: Array) -> Moment:
        """All that terms see.

        Args:
            now: what the task measures.
            measured: q and dq, if they are not those of the simulations.
        """
        state = {"q": self.simulator.q, "dq": self.simulator.dq} | measured
        return Moment(
            self.task, self.simulator.batch, goal=self._goal, now=now, before=self._before,
            action=self._action, change=change, period_s=self.period_s, steps=self.steps, **state,
        )  # fmt: skip

    def _observe(self, now: Any) -> Array:
        q, dq = self.simulator.q, self.simulator.dq
        if not any(self._noise):
            return self._seen(self._moment(now))
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
        true = xp.asarray(self.simulator.q, copy=True)
        self.simulator.put(q)
        now = self._measure()
        self.simulator.put(true)
        return self._seen(self._moment(now, q=q, dq=dq))

    def _seen(self, at: Moment) -> Array:
        return observe(at, self.actions.memory(at.q, self._command))

    def array(self, values: Array) -> Array:
        """Numbers, or truth values, as an array of this environment."""
        return like(values, self.simulator.q)

    def _zeros(self, columns: int) -> Array:
        return self.array(np.zeros((self.rows, columns)))


def _arrays_in(measured: Any) -> list[Array]:
    """The arrays of what a task measures: one, or those in a tuple, a mapping or a data class."""
    if is_array_api_obj(measured):
        return [measured]
    named = measured if isinstance(measured, Mapping) else getattr(measured, "__dict__", {})
    parts = measured if isinstance(measured, (tuple, list)) else named.values()
    return [array for part in parts for array in _arrays_in(part)]
