"""What the joints of a plant feel along recordings: inertia, gravity, sizes for ranges."""

from dataclasses import replace

import mujoco
import numpy as np

from t2l.effects.effect import Scales
from t2l.effects.term import Layout
from t2l.identify.drive_torque import drive_torque
from t2l.identify.initial_state import start_state
from t2l.identify.model import Model
from t2l.identify.prediction import Predictor, Request
from t2l.sim.loop import torque_limits

GRAVITY_POSES = 20_000  # numerics: beyond, gravity is interpolated between poses
# numerics: rad and rad/s, of a joint that does not move
LEAST_RANGE, LEAST_SPEED = 1e-3, 1e-3
STOP_S = 1.0  # guess: in which friction alone stops a joint that nothing drives
LOOP_RAD_S = 2 * np.pi  # guess: natural frequency of a joint without gains


def sized(model: Model, predictor: Predictor) -> Model:
    """`model` with the sizes that its recordings give, unless it has some."""
    return model if model.sizes is not None else replace(model, sizes=scales(predictor))


def scales(predictor: Predictor) -> Scales:
    """Sizes for bounds and first guesses, from the plant as it is under what was commanded."""
    recordings, samples = predictor.recordings, predictor.samples
    kp, kd = (np.array([getattr(r, key) for r in recordings]) for key in ("kp", "kd"))
    empty = Request(Layout(()), np.zeros((1, 0)))
    _, dq = predictor.predict([empty], velocity=True)
    velocity = np.nan_to_num(dq[0][0])
    model, njoint = predictor.model(), len(predictor.joints)
    weight = gravity_torque(predictor)
    least, most = torque_limits(model, predictor.joints).T
    torque = drive_torque(predictor, samples.q, velocity, weight)
    torque = np.clip(torque, least[samples.joint], most[samples.joint])

    def per_joint(function, values):
        return np.array([function(values[samples.joint == j]) for j in range(njoint)])

    def rms(values):
        return per_joint(lambda v: np.sqrt(np.mean(v**2)), values)

    step = np.array(
        [
            np.abs(np.diff(r.kp * r.q_des + r.feed_forward, axis=0)).max(axis=0, initial=0)
            for r in recordings
        ]
    ).max(axis=0)
    dofs = [model.joint(name).dofadr[0] for name in predictor.joints]
    bodies = [model.joint(name).bodyid[0] for name in predictor.joints]
    inertia, speed = joint_inertia(predictor), np.maximum(rms(velocity), LEAST_SPEED)
    usual = np.maximum(np.maximum(rms(torque), rms(weight)), inertia * speed / STOP_S)
    rate_hz = max(r.control_rate_hz for r in recordings)
    kp, kd = kp.max(axis=0), kd.max(axis=0)
    return Scales(
        torque=usual,
        inertia=inertia,
        velocity=speed,
        peak_torque=np.maximum(per_joint(lambda v: np.abs(v).max(), torque), usual),
        peak_torque_rate=np.maximum(step * rate_hz, usual / STOP_S),
        total_torque=np.full(njoint, usual.sum()),
        mass=model.body_subtreemass[bodies],
        control_rate_hz=rate_hz,
        range=np.maximum(per_joint(np.ptp, samples.q), LEAST_RANGE),
        centre=per_joint(np.mean, samples.q),
        kp=np.where(kp > 0, kp, inertia * LOOP_RAD_S**2),
        kd=np.where(kd > 0, kd, inertia * LOOP_RAD_S),
        armature=model.dof_armature[dofs],
        friction=model.dof_frictionloss[dofs],
        damping=model.dof_damping[dofs],
        plant=model,
        joints=predictor.joints,
    )


def joint_inertia(predictor: Predictor) -> np.ndarray:
    """Diagonal of the mass matrix where the first recording starts, (njoint,) kg·m²."""
    model = predictor.model()
    data = mujoco.MjData(model)
    qpos = [model.joint(name).qposadr[0] for name in predictor.joints]
    data.qpos[qpos] = start_state(predictor.recordings[0])[0]
    mujoco.mj_forward(model, data)
    mass = np.zeros((model.nv, model.nv))
    mujoco.mj_fullM(model, data, mass)
    return np.diag(mass)[[model.joint(name).dofadr[0] for name in predictor.joints]]


def gravity_torque(predictor: Predictor, q: np.ndarray | None = None) -> np.ndarray:
    """Gravity torque N·m at each sample, (nsample,): what holding the arm still takes.

    Args:
        q: (nsample,) positions, rad; by default the measured ones.
    """
    model, samples = predictor.model(), predictor.samples
    data = mujoco.MjData(model)
    qpos = [model.joint(name).qposadr[0] for name in predictor.joints]
    dofs = [model.joint(name).dofadr[0] for name in predictor.joints]
    every = 1 + sum(len(r.time) for r in predictor.recordings) // GRAVITY_POSES
    positions = samples.by_row(samples.q if q is None else q)
    signals, bias = [], np.empty(model.nv)
    for recording, position in zip(predictor.recordings, positions, strict=True):
        measured = np.flatnonzero(~np.isnan(recording.q).all(axis=1))
        rows = np.union1d(measured[::every], measured[-1:])
        known = np.empty((len(rows), len(dofs)))
        for i, row in enumerate(rows):
            data.qpos[qpos] = np.where(np.isnan(position[row]), recording.q_des[row], position[row])
            mujoco.mj_kinematics(model, data)
            mujoco.mj_comPos(model, data)
            mujoco.mj_comVel(model, data)
            mujoco.mj_rne(model, data, 0, bias)
            known[i] = bias[dofs]
        at = np.arange(len(recording.time))
        signals.append(np.column_stack([np.interp(at, rows, column) for column in known.T]))
    return samples.of(signals)
