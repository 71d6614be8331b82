"""A model as plain MJCF: MuJoCo stepping it alone moves as t2l predicts."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial

import mujoco
import numpy as np

from t2l.effects.blame import blaming
from t2l.effects.effect import Effect
from t2l.effects.exported import MOTOR, Exported
from t2l.effects.term import Layout, Term
from t2l.effects.torque_saturation import cut_torque
from t2l.identify.model import Model
from t2l.robots import plant

UNLIMITED = 1e9  # N·m, in place of infinity, which MJCF has not
NOTHING = 1e-9  # N·m, in place of zero, of which MJCF makes no range


@dataclass(frozen=True)
class Controller:
    """The loop that the exported robot has, before effects change it.

    Attributes:
        joints: that it drives.
        kp, kd: (njoint,) N·m/rad and N·m·s/rad.
        control_rate_hz: of the loop.
        gravity_compensation: whether the loop cancels gravity.
    """

    joints: tuple[str, ...]
    kp: np.ndarray
    kd: np.ndarray
    control_rate_hz: float
    gravity_compensation: bool


def export(model: Model, controller: Controller, layout: Layout, u: np.ndarray) -> Exported:
    """The robot with its effects at u (n,), and actuators of the names of its joints.

    Raises:
        ConfigurationError: the robot cannot be loaded.
        EffectError: an effect of the user's own fails.
    """
    spec = _plant(model.robot, controller.joints, layout.terms)
    to = Exported(
        spec, controller.joints, 1 / controller.control_rate_hz, controller.gravity_compensation,
        controller.kp, controller.kd, plant.compiled(spec, model.robot),
    )  # fmt: skip
    values = layout.decode(u[None])
    for term in layout.terms:
        own = {
            p.name: values[term.effect.name][p.name][0]
            if p.per_joint
            else float(values[term.effect.name][p.name][0, 0])
            for p in term.effect.parameters
        }
        before = len(to.callbacks)
        with blaming([term.effect], "to export it"):
            term.effect.export(to, np.array(term.joints, int), own)
        if term.effect.stateless:
            to.callbacks[before:] = [replace(c, stateless=True) for c in to.callbacks[before:]]
    _finish(to)
    return to


def _plant(robot: str, joints: Sequence[str], terms: Sequence[Term]) -> mujoco.MjSpec:
    """The plant with what effects add to it, the masses that its geoms gave, and no geoms."""
    spec = plant.load(robot, joints)
    for term in terms:
        if type(term.effect).export is not Effect.export:  # or it would add what has no values
            with blaming([term.effect], "to extend the model"):
                term.effect.extend(spec, tuple(joints[j] for j in term.joints))
    compiled = plant.compiled(spec, robot)
    for body in spec.bodies:
        if body.name == "world":
            continue
        i = body.id
        body.name = body.name or f"body_{i}"
        body.mass, body.inertia = compiled.body_mass[i], compiled.body_inertia[i]
        body.ipos, body.iquat = compiled.body_ipos[i], compiled.body_iquat[i]
        # that of the file, beside which MuJoCo takes no principal moments
        body.fullinertia = np.full(6, np.nan)
        body.explicitinertial = compiled.body_mass[i] > 0
    spec.compiler.inertiafromgeom = mujoco.mjtInertiaFromGeom.mjINERTIAFROMGEOM_FALSE
    for element in [*spec.geoms, *spec.meshes, *spec.cameras, *spec.lights, *spec.materials,
                    *spec.textures]:  # fmt: skip
        spec.delete(element)
    return spec


def _finish(to: Exported) -> None:
    spec = to.spec
    spec.option.timestep = to.period_s
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_EULER
    spec.option.solver = mujoco.mjtSolver.mjSOL_NEWTON
    for body in spec.bodies:
        carried = to.gravity_compensation and body.name not in ("world", "payload")
        body.gravcomp = float(carried)
    driven = to.each(np.arange(len(to.joints)))
    for j, joint in enumerate(driven):
        _call_for_limit(to, j, joint)
    to.finish()
    for j, joint in enumerate(driven):
        joint.actgravcomp = int(to.gravity_compensation)
        low, high = joint.actfrcrange if joint.actfrclimited == 1 else (-np.inf, np.inf)
        low, high = max(low, -to.limit[j]), min(high, to.limit[j])
        if np.isfinite([low, high]).any():
            # of the motor: the constant is the joint's
            joint.actfrclimited = 1
            joint.actfrcrange = np.clip((low, high), -UNLIMITED, UNLIMITED) + to.constant[j]
        _add_actuator(to, j)
    for joint in spec.joints:
        if to.gravity_compensation and joint.name not in to.joints:
            # only motors compensate gravity, not what is between motor and link
            joint.actgravcomp = joint.actfrclimited = 1
            joint.actfrcrange = -NOTHING, NOTHING


def _call_for_limit(to: Exported, j: int, joint: mujoco.MjsJoint) -> None:
    """Let the MJCF's own limit come after all that changes the motor's torque."""
    low, high = joint.actfrcrange
    limited = joint.actfrclimited != 0 and low < high
    joint.actfrclimited = 0
    if limited:
        to.call(
            "limits of the MJCF", cut_torque, [j], {"low": low, "high": high}, MOTOR,
            element=partial(setattr, joint, "actfrclimited", 1),
        )  # fmt: skip


def _add_actuator(to: Exported, j: int) -> None:
    kp, kd = to.kp[j], to.kd[j]
    actuator = to.spec.add_actuator(
        name=to.joints[j], target=to.joints[j], trntype=mujoco.mjtTrn.mjTRN_JOINT,
        gaintype=mujoco.mjtGain.mjGAIN_FIXED, biastype=mujoco.mjtBias.mjBIAS_AFFINE,
    )  # fmt: skip
    actuator.gainprm[0] = kp
    actuator.biasprm[:3] = to.constant[j], -kp, -(kd - kp * to.period_s / 2)
    if to.lowpass_s[j] > 0:
        actuator.dyntype = mujoco.mjtDyn.mjDYN_FILTEREXACT
        actuator.dynprm[0], actuator.actearly = to.lowpass_s[j], 1
    if to.delay_s[j] > 0:
        actuator.delay, actuator.interp = to.delay_s[j], 1
        actuator.nsample = int(np.ceil(to.delay_s[j] / to.period_s)) + 2
