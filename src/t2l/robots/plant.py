"""Any robot that MuJoCo can load, MJCF or URDF, reduced to the joints that a recording drives."""

import os
import xml.etree.ElementTree as ElementTree
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

import mujoco
import numpy as np

from t2l.documents import check_regular
from t2l.errors import ConfigurationError
from t2l.robots import robot_file
from t2l.robots.registry import ROBOTS, make_robot
from t2l.robots.robot import Robot
from t2l.robots.specs import add_position_actuator, hold_at_rest
from t2l.waiting import told_if_slow

# of a path in a message; more is no path
MOST_CHARACTERS = 500


def mjcf_path(robot: str) -> Path:
    """The MJCF file of a known robot's name, or the MJCF or URDF file of a path.

    Raises:
        ConfigurationError: neither a known name nor a file, or one that is not installed.
    """
    names = ROBOTS.names()
    if robot in names:
        return make_robot(robot).mjcf()
    path = Path(robot)
    # os.path: of a name that is too long for a file, pathlib makes an error
    if not os.path.exists(path):
        raise ConfigurationError(
            f"robot: {robot[:MOST_CHARACTERS]!r} is neither a known name ({', '.join(names)}) "
            "nor an MJCF or URDF file"
        )
    check_regular(path)
    return path


def files(robot: str) -> list[Path]:
    """Every file that a robot's model is made of: its MJCF, what that includes, meshes, textures.

    A file that is not there is left out, and so is what an unreadable MJCF names. What is there
    need be no regular file.
    """
    return list(_files_and_roots(mjcf_path(robot)))


def _files_and_roots(path: Path) -> dict[Path, ElementTree.Element | None]:
    main = path.resolve()
    found: dict[Path, ElementTree.Element | None] = {}
    _collect(main, main.parent, found)
    return found


def _collect(path: Path, home: Path, found: dict[Path, ElementTree.Element | None]) -> None:
    if path in found:
        return
    found[path] = None
    try:
        root = found[path] = ElementTree.parse(path).getroot()
    except (ElementTree.ParseError, OSError, ValueError, LookupError):
        return
    # the attributes of <compiler> that say where files of other kinds are
    folders = [
        home / element.get(key, "")
        for element in root.iter("compiler")
        for key in ("meshdir", "texturedir", "assetdir")
    ]
    for element, name in _named_files(root):
        # MuJoCo looks beside the main file, newer versions beside the including one too
        for folder in (home, path.parent, *folders):
            named = (folder / name).resolve()
            # os.path: of a name that is too long for a file, pathlib makes an error
            if os.path.exists(named) and not os.path.isdir(named):
                if element in ("include", "model") and os.path.isfile(named):
                    _collect(named, home, found)
                else:
                    found[named] = None
                break


def _elsewhere(found: Mapping[Path, ElementTree.Element | None]) -> set[Path]:
    """Where else MuJoCo may look for what XML files name: without folders, and in each other's."""
    roots = {path: root for path, root in found.items() if root is not None}
    main = next(iter(found)).parent
    folders = {path.parent for path in roots} | {
        main / element.get(key, "")
        for root in roots.values()
        for element in root.iter("compiler")
        for key in ("meshdir", "texturedir", "assetdir")
    }
    names = {name for root in roots.values() for _, name in _named_files(root)}
    return {folder / spelt for folder in folders for name in names
            for spelt in (name, os.path.basename(name))}  # fmt: skip


def _named_files(root: ElementTree.Element) -> Iterator[tuple[str, str]]:
    for element in root.iter():
        for key, value in element.attrib.items():
            if key == "file" or key.startswith("file"):
                yield element.tag, value


def compiled(spec: mujoco.MjSpec, what: str) -> mujoco.MjModel:
    """The model that MuJoCo makes of a specification.

    Args:
        what: it is of, for messages.

    Raises:
        ConfigurationError: with what MuJoCo's compiler objects to, such as a body without mass.
    """
    try:
        return spec.compile()
    except ValueError as error:
        reason = " ".join(str(error).split())
        raise ConfigurationError(f"{what}: MuJoCo cannot compile it: {reason}") from None


def as_bytes(model: mujoco.MjModel) -> bytes:
    """A compiled model in MuJoCo's binary format: equal where every number of it is."""
    buffer = np.zeros(mujoco.mj_sizeModel(model), np.uint8)
    mujoco.mj_saveModel(model, None, buffer)
    return buffer.tobytes()


def free_joints(robot: str) -> list[str]:
    """Names of the joints by which the base or a body of a robot floats; "" for one without.

    Raises:
        ConfigurationError: no such robot, or not MJCF.
    """
    joints = read(robot).joints
    return [joint.name for joint in joints if joint.type == mujoco.mjtJoint.mjJNT_FREE]


def read(robot: str) -> mujoco.MjSpec:
    """A robot without tools as its file says, with its looks.

    Raises:
        ConfigurationError: no such robot, neither MJCF nor URDF, or one whose file says what MuJoCo
            would take for something else (see `t2l.robots.robot_file`).
    """
    path = mjcf_path(robot)
    known = robot in ROBOTS.names()
    if not known:
        found = _files_and_roots(path)
        for file in (*found, *_elsewhere(found)):
            check_regular(file)
        robot_file.parsed(path)
        for file, root in found.items():
            if root is not None:
                robot_file.check(file, root)
    try:
        with told_if_slow(f"robot file {path}, to be read"):
            return make_robot(robot).bare() if known else mujoco.MjSpec.from_file(str(path))
    except ValueError as error:
        reason = " ".join(str(error).split())
        raise ConfigurationError(f"{path}: MuJoCo cannot read it: {reason}") from None


def load(robot: str, joints: Sequence[str]) -> mujoco.MjSpec:
    """The plant as its MJCF says: no actuators, no contacts, and only `joints` free to move.

    Every other joint is held at its reference position. The limits of the file's actuators stay
    as the range of each joint's actuator force. Masses that come from geoms are kept; what only
    serves to draw is not.

    Args:
        robot: a known name or the path of an MJCF or URDF file. Of a URDF, MuJoCo takes effort
            limits, damping and friction of joints; meshes are not needed.

    Raises:
        ConfigurationError: no such robot, neither MJCF nor URDF, an unknown joint, one that is
            neither a hinge nor a slide, or a link of a URDF without mass.
    """
    path = mjcf_path(robot)
    spec = read(robot)
    if _root(path) == "robot":
        _check_inertials(spec, path)
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
    # with joint friction within 2e-6 rad of Newton, and a third faster
    spec.option.solver = mujoco.mjtSolver.mjSOL_CG
    for body in spec.bodies:
        if body.name != "world":
            body.gravcomp = 1.0
    return spec


def position_controlled(robot: Robot) -> mujoco.MjSpec:
    """The bare robot under position actuators, for the `discrete` integrator (see `t2l.sim.batch`).

    Neither the MJCF's friction nor its limits of force are in it: `Simulator` adds its own.

    Raises:
        ConfigurationError: files of the robot are not installed.
    """
    spec = load(robot.name, robot.joints)
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_DISCRETE
    for name in robot.joints:
        joint = spec.joint(name)
        joint.actfrclimited = 0
        joint.frictionloss = 0.1  # nonzero, so that friction is part of the compiled model
        hold_at_rest(joint)
        add_position_actuator(spec, name, kp=100.0, kv=10.0)
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
    return [joint for joint in read(robot).joints if joint.type in scalar]


def _root(path: Path) -> str:
    """The tag of an XML file: `mujoco` of an MJCF, `robot` of a URDF; "" if it is no XML."""
    try:
        # iterparse leaves a file open that it opened itself, until it is collected
        with open(path, "rb") as file:
            return next(ElementTree.iterparse(file, events=("start",)))[1].tag
    except (ElementTree.ParseError, OSError, ValueError, StopIteration):
        return ""


def _check_inertials(spec: mujoco.MjSpec, path: Path) -> None:
    """Find a moving link of a URDF whose mass only a mesh could give.

    Raises:
        ConfigurationError: such a link.
    """
    for body in spec.bodies:
        shapes = [geom.type != mujoco.mjtGeom.mjGEOM_MESH for geom in body.geoms]
        if list(body.joints) and not body.explicitinertial and not all(shapes):
            raise ConfigurationError(
                f"{path}: link {body.name}: found no <inertial>; allowed: an <inertial> with mass "
                "and inertia for every link that moves"
            )


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
