"""A model as plain MJCF: MuJoCo stepping it alone moves as t2l predicts."""

from collections.abc import Sequence
from dataclasses import dataclass

import mujoco
import numpy as np

from t2l.effects.blame import blaming
from t2l.effects.exported import Exported
from t2l.effects.term import Layout
from t2l.identify.model import Model
from t2l.robots import plant


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
    to = Exported(
        _without_geometry(model.robot, controller.joints), controller.joints,
        1 / controller.control_rate_hz, controller.gravity_compensation,
        controller.kp, controller.kd,
    )  # fmt: skip
    values = layout.decode(u[None])
    for term in layout.terms:
        own = {
            p.name: values[term.effect.name][p.name][0]
            if p.per_joint
            else float(values[term.effect.name][p.name][0, 0])
            for p in term.effect.parameters
        }
        with blaming([term.effect], "to export it"):
            term.effect.export(to, np.array(term.joints, int), own)
    _finish(to)
    return to


def _without_geometry(robot: str, joints: Sequence[str]) -> mujoco.MjSpec:
    """The plant with the masses that its geoms gave, and without geoms and meshes."""
    spec = plant.load(robot, joints)
    compiled = plant.compiled(spec, robot)
    for body in spec.bodies:
        if body.name == "world":
            continue
        i = body.id
        body.mass, body.inertia = compiled.body_mass[i], compiled.body_inertia[i]
        body.ipos, body.iquat = compiled.body_ipos[i], compiled.body_iquat[i]
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
    for j, joint in enumerate(to.each(np.arange(len(to.joints)))):
        joint.actgravcomp = int(to.gravity_compensation)
        if np.isfinite(to.limit[j]):
            low, high = joint.actfrcrange if joint.actfrclimited == 1 else (-np.inf, np.inf)
            joint.actfrclimited = 1
            joint.actfrcrange = max(low, -to.limit[j]), min(high, to.limit[j])
        _add_actuator(to, j)


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
