"""A policy's rollouts on a robot: of metal, virtual, or the identified simulator."""

import logging
from dataclasses import dataclass, fields
from pathlib import Path

import numpy as np

from t2l.actions import ActionSpace
from t2l.artefacts import read_npz, set_aside, whole
from t2l.environment.interface import observe, steps_held
from t2l.environment.limits import LIMITS, Limits, violations
from t2l.errors import ArtefactError
from t2l.gains import Cell
from t2l.hardware.backend import PositionControlled
from t2l.hardware.features import State
from t2l.hardware.guard import Guard, Workspace
from t2l.hardware.limits import first_of, state_objections
from t2l.policies import Policy
from t2l.sim.batch import make_batch
from t2l.sim.controllers.joint_pd import pd_torque
from t2l.tasks import Rewarded
from t2l.tasks.terms import Moment

log = logging.getLogger(__name__)

LOG_RATE_HZ = 100.0


@dataclass(frozen=True, eq=False)
class Rollouts:
    """What `n` robots measured at `LOG_RATE_HZ`; NaN after the instant at which one was stopped.

    Attributes:
        time: (nsample,) s; the policy decides every `hold` samples.
        q, dq: (nsample, n, njoint); of a robot that was stopped, the last is what stopped it.
        q_des: (nsample, n, njoint), what was sent.
        observation, action: (ndecision, n, nobs) and (ndecision, n, naction), at each decision.
        violated: (nsample, n, nconstraint) bool, in order of `t2l.environment.limits.LIMITS`.
        success: (n,) bool, at the end of those that were not stopped.
        stopped: why each robot was stopped, or nothing.
    """

    time: np.ndarray
    q: np.ndarray
    dq: np.ndarray
    q_des: np.ndarray
    observation: np.ndarray
    action: np.ndarray
    violated: np.ndarray
    success: np.ndarray
    stopped: tuple[str, ...]


def deploy(
    robot: PositionControlled,
    policy: Policy,
    task: Rewarded,
    actions: ActionSpace,
    cell: Cell,
    starts: np.ndarray,
    goals: np.ndarray,
    policy_rate_hz: float,
    duration_s: float,
    workspace: Workspace,
    folder: Path | None = None,
) -> Rollouts:
    """Run a policy from every start to its goal, as many side by side as there are robots.

    Commands are sent at `LOG_RATE_HZ`, whatever the policy's rate, and checked each time. One that
    must not be sent is not: its robot is held where it is, and its rollout ends. So it does where a
    joint is measured beyond a limit, as often as the robot shows it (`PositionControlled.sending`).
    Whatever else ends the deployment, an error or Ctrl-C, the robot is brought to rest first.

    Args:
        actions: what the policy's output means.
        starts: (n, njoint) rad, and goals (n, goal_size); n is a multiple of the number of robots.
        folder: keeps what is complete; what is there already is not run again.

    Raises:
        ConfigurationError: the policy's rate does not divide `LOG_RATE_HZ`.
        BackendError: the robot does not go on.
    """
    hold = steps_held(LOG_RATE_HZ, policy_rate_hz, "the log's")
    parts = []
    for first in range(0, len(starts), robot.n):
        rows = slice(first, first + robot.n)
        kept = folder / f"{first:03d}.npz" if folder else None
        decisions = round(duration_s * policy_rate_hz)
        njoint, naction = starts.shape[1], len(actions.names)
        size = (decisions, hold, robot.n, njoint, naction)
        if kept and (part := _kept(kept, size)):
            parts.append(part)
            continue
        guard = Guard(task.robot, robot.n, 1 / LOG_RATE_HZ, workspace)
        run = _Run(robot, policy, task, actions, cell, goals[rows], guard)
        try:
            parts.append(run.through(starts[rows], hold, decisions))
        except BaseException:
            robot.hold()
            raise
        if kept:
            _write(parts[-1], kept)
    return _joined(parts)


class _Run:
    """One rollout of every robot at once."""

    def __init__(self, robot, policy, task, actions, cell, goals, guard):
        self.robot, self.policy, self.task, self.cell = robot, policy, task, cell
        self.actions, self.goals, self.guard = actions, goals, guard
        # the task is judged in a model that is put where the robot is
        self.mirror = make_batch(task.model, robot.n)
        self.stopped = [""] * robot.n
        # what was found between two samples, to be stopped for at the next
        self.found = [""] * robot.n

    def through(self, starts: np.ndarray, hold: int, decisions: int) -> Rollouts:
        kp, kd = self.task.robot.gains(self.cell.kp, self.cell.kd)
        state = self.robot.start(starts, kp, kd)
        limits = Limits.of(self.task.robot, 1 / LOG_RATE_HZ)
        before = np.zeros_like(state.q)
        previous = np.zeros((self.robot.n, len(self.actions.names)))
        wanted = held = state.q.copy()
        logged: dict[str, list[np.ndarray]] = {
            name: [] for name in ("q", "dq", "q_des", "observation", "action", "violated")
        }
        for sample in range(decisions * hold):
            deciding = sample % hold == 0
            if deciding:
                memory = self.actions.memory(state.q, wanted)
                observation = observe(self.moment(state, previous), memory)
                action = self.policy.action(observation)
                wanted = self.actions.command(action, state.q, wanted)
                previous = action
            running = self.running
            self.stop_where_needed(wanted, state)
            held = np.where(running[:, None] & ~self.running[:, None], state.q, held)
            q_des = np.where(self.running[:, None], wanted, held)
            for name, value in (("q", state.q), ("dq", state.dq)):
                logged[name].append(_without(value, ~running))
            if not self.running.any():
                break
            if deciding:
                for name, value in (("observation", observation), ("action", action)):
                    logged[name].append(_without(value, ~self.running))
            torque = pd_torque(q_des, state.q, state.dq, kp, kd)
            found = violations(state.q, state.dq, torque, before, limits)
            before = torque
            logged["q_des"].append(_without(q_des, ~self.running))
            logged["violated"].append(found & self.running[:, None])
            for state in self.robot.sending(q_des, 1 / LOG_RATE_HZ):
                beyond = state_objections(self.task.robot, state.q, state.dq)
                self.found = first_of(self.found, beyond)
        if not self.running.all():
            self.robot.hold()
        success = self.task.success(self.moment(state, previous)) & self.running
        njoint, naction = starts.shape[1], len(self.actions.names)
        sizes = {
            "q": njoint, "dq": njoint, "q_des": njoint, "violated": len(LIMITS), "action": naction,
            "observation": observation.shape[1],
        }  # fmt: skip
        arrays = {
            name: _padded(rows, decisions * (1 if name in ("observation", "action") else hold),
                          self.robot.n, sizes[name])
            for name, rows in logged.items()
        }  # fmt: skip
        arrays["violated"] = arrays["violated"] == 1
        time = np.arange(decisions * hold) / LOG_RATE_HZ
        return Rollouts(time=time, success=success, stopped=tuple(self.stopped), **arrays)

    @property
    def running(self) -> np.ndarray:
        return np.array([not reason for reason in self.stopped])

    def moment(self, state: State, action: np.ndarray) -> Moment:
        self.mirror.qpos[:, self.task.arm_qpos] = state.q
        now = self.task.measure(self.mirror, self.goals)
        return Moment(self.task, self.mirror, state.q, state.dq, self.goals, now, action=action)

    def stop_where_needed(self, q_des: np.ndarray, state: State) -> None:
        objections = self.guard.objections(q_des, state.q, state.dq)
        self.stopped = first_of(self.stopped, self.found, objections)


def _without(values: np.ndarray, robots: np.ndarray) -> np.ndarray:
    values = np.array(values, float)
    values[robots] = np.nan
    return values


def _padded(rows: list[np.ndarray], length: int, n: int, size: int) -> np.ndarray:
    """(length, n, size): rows, and NaN for those that never came."""
    padded = np.full((length, n, size), np.nan)
    if rows:
        padded[: len(rows)] = rows
    return padded


def _joined(parts: list[Rollouts]) -> Rollouts:
    def along(name: str, axis: int) -> np.ndarray:
        return np.concatenate([getattr(part, name) for part in parts], axis=axis)

    sampled = ("q", "dq", "q_des", "observation", "action", "violated")
    return Rollouts(
        time=parts[0].time,
        success=along("success", 0),
        stopped=sum((part.stopped for part in parts), ()),
        **{name: along(name, 1) for name in sampled},
    )


def _write(rollouts: Rollouts, path: Path) -> None:
    with whole(path) as draft:
        np.savez(draft, **{field.name: getattr(rollouts, field.name) for field in fields(Rollouts)})


def _kept(path: Path, size: tuple[int, ...]) -> Rollouts | None:
    """What an earlier run kept; a file that is no such rollout is set aside."""
    if not path.exists():
        return None
    try:
        return _read(path, size)
    except ArtefactError as error:
        log.warning("%s; set aside as %s and run anew", error.complaint, set_aside(path).name)
        return None


def _read(path: Path, size: tuple[int, ...]) -> Rollouts:
    decisions, hold, n, njoint, naction = size
    samples = decisions * hold
    shapes = {
        "time": (samples,), "violated": (samples, n, len(LIMITS)), "success": (n,), "stopped": (n,),
        "action": (decisions, n, naction),
    } | {name: (samples, n, njoint) for name in ("q", "dq", "q_des")}  # fmt: skip
    kinds = {"violated": "b", "success": "b", "stopped": "U"}
    arrays = read_npz(path, names := [field.name for field in fields(Rollouts)])
    for name in names:
        found = arrays[name]
        # how much is observed is the task's
        shape = shapes.get(name, (decisions, n, *found.shape[2:3]))
        if found.shape != shape or found.dtype.kind != kinds.get(name, "f"):
            described = f"{name} is {found.dtype} of {found.shape}"
            raise ArtefactError(path, described, f"rollouts with {name} of {shape}")
    content = {name: arrays[name] for name in names}
    return Rollouts(**content | {"stopped": tuple(map(str, content["stopped"]))})
