"""Any robot that MuJoCo can load, reduced to the joints that a recording drives."""

from collections.abc import Sequence
from pathlib import Path

import mujoco
import numpy as np

from t2l.errors import ConfigurationError

KNOWN = ("fr3",)


def mjcf_path(robot: str) -> Path:
    """The MJCF file of a known robot's name, or of a path.

    Raises:
        ConfigurationError: neither a known name nor a file.
    """
    if robot == "fr3":
        from t2l.robots import fr3

        return fr3.mjcf_path()
    path = Path(robot)
    if not path.is_file():
        raise ConfigurationError(
            f"robot: {robot!r} is neither a known name ({', '.join(KNOWN)}) nor an MJCF file"
        )
    return path


def load(robot: str, joints: Sequence[str]) -> mujoco.MjSpec:
    """The plant as its MJCF says: no actuators, no contacts, and only `joints` free to move.

    Every other joint is held at its reference position. The limits of the file's actuators stay
    as the range of each joint's actuator force. Masses that come from geoms are kept; what only
    serves to draw is not.

    Args:
        robot: a known name or the path of an MJCF file.

    Raises:
        ConfigurationError: no such robot, not MJCF, an unknown joint, or one that is neither a
            hinge nor a slide.
    """
    path = mjcf_path(robot)
    spec = _read(path)
    allowed = [joint.name for joint in scalar_joints(robot)]
    for name in joints:
        if name not in allowed:
            raise ConfigurationError(
                f"{path}: no hinge or slide joint named {name!r}; it has {', '.join(allowed)}"
            )
    for actuator in list(spec.actuators):
        _keep_force_limit(spec, actuator)
    always = spec.compiler.inertiafromgeom == mujoco.mjtInertiaFromGeom.mjINERTIAFROMGEOM_TRUE
    geoms = [geom for geom in spec.geoms if not (always or _gives_mass(geom))]
    held = {joint.name for joint in spec.joints} - set(joints)
    for element in [
        *_tendons_on(spec, held),
        *spec.actuators, *spec.sensors, *spec.keys, *spec.excludes, *spec.pairs, *spec.equalities,
        *(joint for joint in spec.joints if joint.name not in joints), *geoms,
    ]:  # fmt: skip
        spec.delete(element)
    if not list(spec.geoms):
        for mesh in list(spec.meshes):
            spec.delete(mesh)
    spec.option.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONTACT
    # a robot is one tree: to look for islands of constraints costs a tenth of a step
    spec.option.disableflags |= mujoco.mjtDisableBit.mjDSBL_ISLAND
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    # for joint friction alone as exact as Newton (1e-8 rad) and a third faster
    spec.option.solver = mujoco.mjtSolver.mjSOL_CG
    for body in spec.bodies:
        if body.name != "world":
            body.gravcomp = 1.0
    return spec


def _tendons_on(spec: mujoco.MjSpec, joints: set[str]) -> list[mujoco.MjsTendon]:
    return [
        tendon
        for tendon in spec.tendons
        if any(wrap.target is not None and wrap.target.name in joints for wrap in tendon.path)
    ]


def _gives_mass(geom: mujoco.MjsGeom) -> bool:
    body = geom.parent
    if body.explicitinertial:
        return False
    while body.parent is not None:
        if list(body.joints):
            return True
        body = body.parent
    return False


def scalar_joints(robot: str) -> list[mujoco.MjsJoint]:
    """The hinges and slides of a robot's MJCF, in its order.

    Raises:
        ConfigurationError: no such robot, or not MJCF.
    """
    scalar = (mujoco.mjtJoint.mjJNT_HINGE, mujoco.mjtJoint.mjJNT_SLIDE)
    return [joint for joint in _read(mjcf_path(robot)).joints if joint.type in scalar]


def _read(path: Path) -> mujoco.MjSpec:
    try:
        return mujoco.MjSpec.from_file(str(path))
    except ValueError as error:
        raise ConfigurationError(f"{path}: MuJoCo cannot read it: {error}") from None


def _keep_force_limit(spec: mujoco.MjSpec, actuator: mujoco.MjsActuator) -> None:
    if actuator.trntype != mujoco.mjtTrn.mjTRN_JOINT or actuator.forcelimited == 0:
        return
    low, high = np.asarray(actuator.forcerange) * abs(actuator.gear[0])
    if low < high:
        joint = spec.joint(actuator.target)
        joint.actfrclimited = 1
        joint.actfrcrange = (low, high)


def position_ranges(model: mujoco.MjModel, joints: Sequence[str]) -> np.ndarray:
    """(njoint, 2) rad, infinite where the MJCF states none."""
    ranges = np.full((len(joints), 2), (-np.inf, np.inf))
    for i, name in enumerate(joints):
        joint = model.joint(name)
        if model.jnt_limited[joint.id]:
            ranges[i] = model.jnt_range[joint.id]
    return ranges
