"""A motion as a control loop is shown it: with what the plant takes to move so."""

import copy
from collections.abc import Callable, Sequence

import mujoco
import numpy as np

from t2l.effects.blame import blaming
from t2l.effects.effect import Effect
from t2l.effects.term import Layout, Term
from t2l.identify.prediction import Predictor
from t2l.identify.simulation import install
from t2l.sim.driven_loop import DrivenLoop, Path
from t2l.sim.poses import Poses
from t2l.sim.schedule import Schedule

Variants = tuple[Layout, np.ndarray]
NOTHING: Variants = Layout(()), np.zeros((1, 0))


def path_of(
    predictor: Predictor,
    base: tuple[Layout, np.ndarray],
    schedule: Schedule,
    motion: Sequence[np.ndarray],
    at_rest: np.ndarray,
) -> tuple[Path, Poses]:
    """A motion at the ticks of a schedule, and some of its places, each halfway between two ticks.

    Args:
        base: the model so far, layout and u (n,).
        motion: q, dq and ddq (ntick, nrec, njoint), the last on average until the next tick.
        at_rest: (njoint,) rad/s, see `Path`.
    """
    at_ticks = Poses(*motion, schedule.period_s)
    load, weight = _loads(predictor, base[0], at_ticks)
    # a loop cancels it at its own ticks, of which a coarse one has many, a balance all the time
    later = np.full(len(schedule.kp), (1 - 1 / schedule.coarseness) / 2)
    later[schedule.balanced] = 0.5
    weight[:-1] += later[:, None] * np.diff(weight, axis=0)
    between = *(_halfway(values) for values in motion[:2]), motion[2]
    poses = Poses(*between, schedule.period_s)
    taken = _taken(predictor.model(), predictor.joints, between)
    # what the model so far has more
    bodies = added_by_bodies(predictor, schedule, poses, NOTHING, (base[0], base[1][None]))
    taken -= bodies if np.isscalar(bodies) else bodies[:, 0]
    # there is no tick after the last
    taken[-1] = taken[-2]
    link = taken - _of_rotors(predictor.model(), predictor.joints, between)
    taken -= schedule.balanced[:, None] * weight
    return Path(*motion, load, weight, at_rest, taken, link), poses


def with_both(predictor: Predictor, base: Variants, layout: Layout) -> mujoco.MjModel:
    """The plant with what either adds to its structure: a variant may lack a term of the model."""
    joints: dict[str, tuple[Effect, set[int]]] = {}
    for term in (*layout.terms, *base[0].terms):
        joints.setdefault(term.effect.name, (term.effect, set()))[1].update(term.joints)
    return predictor.model([Term(effect, tuple(sorted(on))) for effect, on in joints.values()])


def added_by_bodies(
    predictor: Predictor, schedule: Schedule, poses: Poses, base: Variants, variants: Variants
) -> np.ndarray | float:
    """N·m (ntick, m, nrec, n) that other masses or another gravity give variants beyond `base`.

    Zero if they have none.
    """
    layout, u = variants
    model = with_both(predictor, base, layout)
    loop = DrivenLoop(model, predictor.joints, schedule, len(u) + 1)
    with blaming([term.effect for term in layout.terms], "to lead it"):
        install(loop, [base, variants])
    taken = loop.by_bodies(poses)
    if taken is None:
        return 0.0
    return poses.at_ticks((taken[:, :1] - taken[:, 1:]).astype(np.float32))


def _loads(predictor: Predictor, layout: Layout, poses: Poses) -> tuple[np.ndarray, np.ndarray]:
    """N·m (ntick, nrec, n) of weight and velocity, and of the weight of the nominal model."""
    model, joints = predictor.model(layout.terms), predictor.joints
    data, weight_of = mujoco.MjData(model), weight_at(predictor.model(), joints)
    qpos = [model.joint(name).qposadr[0] for name in joints]
    dofs = [model.joint(name).dofadr[0] for name in joints]
    load, weight = np.empty((2, *poses.q.shape))
    for index in np.ndindex(poses.q.shape[:2]):
        data.qpos[qpos], data.qvel[dofs] = poses.q[index], poses.dq[index]
        mujoco.mj_fwdPosition(model, data)
        mujoco.mj_fwdVelocity(model, data)
        load[index], weight[index] = data.qfrc_bias[dofs], weight_of(poses.q[index])
    return poses.at_ticks(load), poses.at_ticks(weight)


def _halfway(values: np.ndarray) -> np.ndarray:
    """From each tick to the next."""
    return np.concatenate([(values[1:] + values[:-1]) / 2, values[-1:]])


def _taken(
    model: mujoco.MjModel, joints: Sequence[str], motion: Sequence[np.ndarray]
) -> np.ndarray:
    """N·m (ntick, nrec, n) that a motion q, dq and ddq takes of a model."""
    model = copy.copy(model)
    model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONSTRAINT
    model.body_gravcomp[:] = 0.0
    data = mujoco.MjData(model)
    qpos = [model.joint(name).qposadr[0] for name in joints]
    dofs = [model.joint(name).dofadr[0] for name in joints]
    out = np.empty(motion[0].shape)
    for index in np.ndindex(out.shape[:2]):
        data.qpos[qpos], data.qvel[dofs], data.qacc[dofs] = (values[index] for values in motion)
        mujoco.mj_inverse(model, data)
        out[index] = data.qfrc_inverse[dofs]
    return out


def _of_rotors(
    model: mujoco.MjModel, joints: Sequence[str], motion: Sequence[np.ndarray]
) -> np.ndarray:
    """N·m (ntick, nrec, n) that the armature, dampers and springs of joints take of that."""
    ids = [model.joint(name).id for name in joints]
    dofs, qpos = model.jnt_dofadr[ids], model.jnt_qposadr[ids]
    q, dq, ddq = motion
    springs = model.jnt_stiffness[ids] * (q - model.qpos_spring[qpos])
    return model.dof_armature[dofs] * ddq + model.dof_damping[dofs] * dq + springs


def weight_at(model: mujoco.MjModel, joints: Sequence[str]) -> Callable[[np.ndarray], np.ndarray]:
    """N·m (n,) that carry a model still, from the positions (n,) of its joints."""
    data, bias = mujoco.MjData(model), np.zeros(model.nv)
    qpos = [model.joint(name).qposadr[0] for name in joints]
    dofs = [model.joint(name).dofadr[0] for name in joints]

    def weight(q: np.ndarray) -> np.ndarray:
        data.qpos[qpos] = q
        mujoco.mj_kinematics(model, data)
        mujoco.mj_comPos(model, data)
        mujoco.mj_comVel(model, data)
        mujoco.mj_rne(model, data, 0, bias)
        return bias[dofs]

    return weight
