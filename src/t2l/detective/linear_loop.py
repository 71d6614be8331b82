"""The control loop linearised along a motion: how positions answer to small torques.

    M δq̈ = δτ − K δq − D δq̇,   K, D = inverse dynamics, springs, dampers, less the controller's

discretised over a tick, implicit in the damping. So x = (δq, δq̇) follows x' = A_t x + B_t δτ_t,
and the response to any torque is one pass over the ticks, for all torques at once.

Source: Åström and Wittenmark, Computer-controlled systems, 1997, section 2.3; along a trajectory,
Ljung, System identification, 1999, section 4.2.
"""

import copy
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import mujoco
import numpy as np

from t2l.detective.motion import Motion, mean_ddq
from t2l.detective.paths import path_of, weight_at
from t2l.detective.transmissions import Links
from t2l.effects.term import Layout
from t2l.identify.prediction import Predictor
from t2l.identify.simulation import hermite, install
from t2l.sim.driven_loop import AFTER_MOTOR, DrivenLoop, Path, all_at_once
from t2l.sim.poses import COARSE_PER_S, Poses
from t2l.sim.schedule import Schedule

STEP_RAD = 1e-6  # numerics: of finite differences
STEP_RAD_S = 1e-6  # numerics: likewise
# tuned: of a joint's usual speed, below which the sign of its velocity is not known
AT_REST = 0.02


@dataclass(frozen=True)
class Section:
    """A group of recordings, linearised.

    Attributes:
        path: what the recordings did; `predicted`, what the model so far does.
        step, torque: (ntick, nrec, 2n, 2n) and (ntick, nrec, 2n, n) of x and of δτ.
        poses: of the path.
        links: of the path.
    """

    motion: Motion
    path: Path
    predicted: Path
    poses: Poses
    step: np.ndarray
    torque: np.ndarray
    links: Links
    _motors: dict = field(default_factory=dict, repr=False)

    def motor_torque(
        self, predictor: Predictor, base: tuple[Layout, np.ndarray]
    ) -> np.ndarray | None:
        """N·m (ntick, nrec, n) of the motors of a model u (n,); None if more of it remembers."""
        layout, u = base
        key = (*(slot.key for slot in layout.slots), u.tobytes())
        if key not in self._motors:
            schedule = self.motion.group.schedule
            memory = [term for term in layout.terms if term.effect.remembers]
            at = [i for i, slot in enumerate(layout.slots) if slot.term in memory]
            model = predictor.model(layout.terms)
            loop = DrivenLoop(model, predictor.joints, schedule, 1)
            install(loop, [(Layout(memory), u[None, at])])
            known = None
            after = any(loop.places[name] for name in AFTER_MOTOR)
            if not after and schedule.hold is None:
                loop = DrivenLoop(model, predictor.joints, schedule, 1)
                install(loop, [(layout, u[None])])
                known = loop.motor_torque(self.path)[:, 0]
            self._motors[key] = known
        return self._motors[key]


def linearised(
    predictor: Predictor,
    layout: Layout,
    u: np.ndarray,
    motions: Sequence[Motion],
    feedback: tuple[Layout, np.ndarray] | None = None,
) -> list[Section]:
    """Sections of every group along its motion, at the model so far u (n,).

    Args:
        feedback: another model, of which the controller's derivatives are taken instead.
    """
    return [_section(predictor, layout, u, motion, feedback) for motion in motions]


def _section(
    predictor: Predictor,
    layout: Layout,
    u: np.ndarray,
    motion: Motion,
    feedback: tuple[Layout, np.ndarray] | None,
) -> Section:
    model, joints = predictor.model(layout.terms), predictor.joints
    schedule = motion.group.schedule
    speed = np.sqrt(np.mean(motion.dq**2, axis=(0, 1)))
    # numerics: standard errors of a velocity, of the usual speed at most; above zero
    at_rest = np.maximum(AT_REST * speed, np.minimum(3 * motion.noise_dq, 0.3 * speed)) + 1e-9
    measured = motion.q, motion.dq, motion.ddq
    path, poses = path_of(predictor, (layout, u), schedule, measured, at_rest)
    carried = schedule.compensated | schedule.balanced
    some = Poses(*measured, schedule.period_s, COARSE_PER_S)
    rigid = _rigid(model, predictor.model(), joints, some, carried)
    plant = _Plant(*(some.at_ticks(one) for one in rigid))
    step, torque = _discrete(predictor, *(feedback or (layout, u)), motion, path, plant, model)
    ddq = mean_ddq(motion.predicted_dq, schedule.period_s)
    predicted = motion.predicted, motion.predicted_dq, ddq
    own, _ = path_of(predictor, (layout, u), schedule, predicted, at_rest)
    dofs = [model.joint(name).dofadr[0] for name in joints]
    ids = [model.joint(name).id for name in joints]
    mass = plant.mass - np.diag(model.dof_armature[dofs])
    felt = plant.by_q - np.diag(model.jnt_stiffness[ids])
    weighed = mass, felt + plant.carried, felt
    links = Links(*(one.astype(np.float32) for one in weighed))
    return Section(motion, path, own, poses, step, torque, links)


@dataclass(frozen=True)
class _Plant:
    """Mass matrix, and derivatives of what the motion takes beyond what cancels the weight.

    (ntick, nrec, n, n) each; `carried`, derivatives by q of what cancels it.
    """

    mass: np.ndarray
    by_q: np.ndarray
    by_dq: np.ndarray
    carried: np.ndarray


def _rigid(
    model: mujoco.MjModel,
    nominal: mujoco.MjModel,
    joints: Sequence[str],
    poses: Poses,
    carried: np.ndarray,
) -> tuple[np.ndarray, ...]:
    """Arrays of `_Plant`.

    Args:
        carried: (nrec,) bool, whether the weight is cancelled.
    """
    model = copy.copy(model)
    model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONSTRAINT
    model.body_gravcomp[:] = 0.0  # what cancels the weight is the controller's
    data = mujoco.MjData(model)
    qpos = [model.joint(name).qposadr[0] for name in joints]
    dofs = [model.joint(name).dofadr[0] for name in joints]
    weight_of = weight_at(nominal, joints)
    n, shape = len(dofs), poses.q.shape[:2]
    mass, by_q, by_dq, cancelled = np.zeros((4, *shape, n, n))
    full = np.zeros((model.nv, model.nv))

    def inverse(q, dq, ddq):
        data.qpos[qpos], data.qvel[dofs], data.qacc[dofs] = q, dq, ddq
        mujoco.mj_inverse(model, data)
        return data.qfrc_inverse[dofs]

    for index in np.ndindex(shape):
        q, dq, ddq = (values[index] for values in (poses.q, poses.dq, poses.ddq))
        whole, weight = inverse(q, dq, ddq).copy(), weight_of(q).copy()
        mujoco.mj_fullM(model, data, full)
        mass[index] = full[np.ix_(dofs, dofs)]
        for j, unit in enumerate(np.eye(n)):
            more = inverse(q + STEP_RAD * unit, dq, ddq) - whole
            if carried[index[1]]:
                cancelled[index][:, j] = (weight_of(q + STEP_RAD * unit) - weight) / STEP_RAD
            by_q[index][:, j] = more / STEP_RAD - cancelled[index][:, j]
            by_dq[index][:, j] = (inverse(q, dq + STEP_RAD_S * unit, ddq) - whole) / STEP_RAD_S
    return mass, by_q, by_dq, cancelled


def _discrete(predictor, layout, u, motion: Motion, path: Path, plant: _Plant, model):
    schedule = motion.group.schedule
    ntick, nrec, n = path.q.shape
    h = schedule.period_s
    stiffness, damping = _controller(predictor, layout, u, schedule, path, model)
    loop = DrivenLoop(model, predictor.joints, schedule, 1)
    install(loop, [(layout, u[None])])
    more = loop.ahead * loop.kd + loop.added_armature()
    mass = plant.mass + more[..., None] * np.eye(n)
    k, d = plant.by_q - stiffness, plant.by_dq - damping
    inverse = np.linalg.inv(mass + h * d)
    step = np.empty((ntick, nrec, 2 * n, 2 * n), np.float32)
    torque = np.empty((ntick, nrec, 2 * n, n), np.float32)
    # v' = (M + hD)⁻¹ (M v + h (u − K q)),  q' = q + h (v + v') / 2
    by_v, by_x, by_u = inverse @ mass, -h * inverse @ k, h * inverse
    eye = np.eye(n)
    step[..., n:, n:], step[..., n:, :n], torque[..., n:, :] = by_v, by_x, by_u
    step[..., :n, n:] = 0.5 * h * (by_v + eye)
    step[..., :n, :n] = eye + 0.5 * h * by_x
    torque[..., :n, :] = 0.5 * h * by_u
    return step, torque


def _controller(predictor, layout, u, schedule, path: Path, model):
    """Derivatives of the torque of a loop by position and velocity, (ntick, nrec, n, n) each.

    What remembers is left out: it would need the order of the ticks. Dry friction damps near rest;
    if it held whatever comes, the loop could not be followed by small changes.
    """
    ntick, nrec, n = path.q.shape
    kept = Layout([term for term in layout.terms if not term.effect.remembers])
    u = u[[i for i, slot in enumerate(layout.slots) if not slot.term.effect.remembers]]
    flat, whole = all_at_once(schedule, ntick), replace(path, holds=False).all_at_once()

    def at(path: Path) -> np.ndarray:
        loop = DrivenLoop(model, predictor.joints, flat, 1)
        install(loop, [(kept, u[None])])
        return loop.torque(path)[0, 0].reshape(ntick, nrec, n)

    base = at(whole)

    def by(name: str, step: float) -> np.ndarray:
        moved = (getattr(whole, name) + step * unit for unit in np.eye(n))
        return np.stack([(at(replace(whole, **{name: x})) - base) / step for x in moved], axis=-1)

    return by("q", STEP_RAD), by("dq", STEP_RAD_S)


class _Sampled:
    """Positions (k, m) of samples between two ticks each, put together as ticks go by.

    Args:
        wanted: of each sample the recording, the place of the tick before it among those that are
            looked at, the part of a period since then, and the joint.
    """

    def __init__(self, wanted: Sequence[np.ndarray], schedule: Schedule, m: int):
        recording, place, part, of = wanted
        self.position = np.zeros((len(recording), m), np.float32)
        unit = np.eye(4)
        q0, q1, v0, v1 = (
            hermite(part, schedule.period_s, *one).astype(np.float32)[:, None] for one in unit
        )
        self.recording, self.of = recording, of
        self.joints = schedule.kp.shape[1]
        # of those before and after a tick: which, and weights of position and velocity
        self.at: dict[int, list[tuple[np.ndarray, np.ndarray, np.ndarray]]] = {}
        for ends, by_q, by_v in ((place, q0, v0), (place + 1, q1, v1)):
            order = np.argsort(ends, kind="stable")
            places, first = np.unique(ends[order], return_index=True)
            for at, some in zip(places, np.split(order, first[1:]), strict=True):
                tick = int(schedule.sample_ticks[at])
                self.at.setdefault(tick, []).append((some, by_q[some], by_v[some]))

    def take(self, tick: int, x: np.ndarray) -> None:
        """Take from what joints are off by at a tick, (nrec, 2n, m): positions, velocities."""
        for some, by_q, by_v in self.at.get(tick, ()):
            recording, of = self.recording[some], self.of[some]
            self.position[some] += by_q * x[recording, of] + by_v * x[recording, self.joints + of]


def respond(
    section: Section,
    torque: np.ndarray,
    joint: np.ndarray | None = None,
    chosen: np.ndarray | slice = slice(None),
) -> np.ndarray:
    """Position of samples of a group in answer to torques, (k, m) for m of them.

    Args:
        torque: (ntick, nrec, m) on `joint` (m,) each, or (ntick, nrec, n, m).
        chosen: which of the group's samples.
    """
    ntick, nrec, n = section.path.q.shape
    group, m = section.motion.group, torque.shape[-1]
    half = np.float32(0.5 * group.schedule.period_s)
    torque = torque.astype(np.float32, copy=False)
    answers = _Sampled([values[chosen] for values in group.wanted], group.schedule, m)
    x, later, push = (np.zeros((nrec, k, m), np.float32) for k in (2 * n, n, n))
    q, v = x[:, :n], x[:, n:]
    for tick in range(ntick):
        answers.take(tick, x)
        by = section.torque[tick, :, n:]
        if joint is None:
            np.matmul(by, torque[tick], out=push)
        else:
            np.multiply(by[:, :, joint], torque[tick][:, None], out=push)
        np.matmul(section.step[tick, :, n:], x, out=later)
        later += push
        # positions go on with the mean of both velocities
        v += later
        v *= half
        q += v
        v[:] = later
    return answers.position
