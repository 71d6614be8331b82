"""A robot of which there is only an MJCF or URDF file, with the limits that it lacks."""

import logging
import xml.etree.ElementTree as ElementTree
from collections.abc import Sequence
from pathlib import Path

import mujoco
import numpy as np

from t2l.errors import ConfigurationError
from t2l.robots import plant
from t2l.robots.couplings import couplings
from t2l.robots.robot import JointGroup, Robot

logger = logging.getLogger(__name__)


class RobotFromFile(Robot):
    """One group of all hinges and slides of a file; its home is the first keyframe, or zero.

    Args:
        velocity_limit: rad/s, (njoint,); by default what a URDF states.
        torque_limit: N·m, (njoint,); by default the ranges of force of the file's actuators or
            joints.

    Raises:
        ConfigurationError: the file is no robot, or neither it nor the arguments state a limit.
    """

    def __init__(
        self,
        path: Path | str,
        velocity_limit: Sequence[float] | None = None,
        torque_limit: Sequence[float] | None = None,
    ):
        self._path = Path(path).resolve()
        self.name = str(self._path)
        joints = tuple(joint.name for joint in plant.scalar_joints(self.name))
        model = plant.compiled(plant.load(self.name, joints), self.name)
        for sentence in couplings(self.name, joints):
            logger.warning("%s: %s", self.name, sentence)
        if velocity_limit is None:
            velocity_limit = _velocities_of_urdf(self._path, joints)
        if torque_limit is None:
            torque_limit = _torques(model, joints)
        for key, limit in (("velocity_rad_s", velocity_limit), ("torque_nm", torque_limit)):
            if not np.isfinite(limit).all():
                raise ConfigurationError(
                    f"key limits.{key}: found nothing, and {self._path.name} states none for "
                    f"{joints[int(np.argmin(np.isfinite(limit)))]}; allowed: a number above 0, or "
                    "one for each joint"
                )
        sites = [model.site(i).name for i in range(model.nsite)]
        self.groups = (
            JointGroup(
                name="arm",
                joints=joints,
                proximal=len(joints),
                home=tuple(home_of(self._path, model, joints).tolist()),
                velocity_limit=tuple(map(float, velocity_limit)),
                torque_limit=tuple(map(float, torque_limit)),
                torque_rate_limit=(np.inf,) * len(joints),
                tool_site=sites[-1] if sites else "",
            ),
        )

    def mjcf(self) -> Path:
        """See `Robot.mjcf`."""
        return self._path

    def spec(self, gravity_compensation: bool = True, visual: bool = False) -> mujoco.MjSpec:
        """See `Robot.spec`; nothing but the plant is kept."""
        spec = plant.position_controlled(self)
        for body in spec.bodies:
            body.gravcomp = float(gravity_compensation and body.name != "world")
        return spec


def _velocities_of_urdf(path: Path, joints: Sequence[str]) -> np.ndarray:
    # MuJoCo reads `effort` of <limit> and not `velocity`
    found = {}
    root = ElementTree.parse(path).getroot()
    for joint in root.findall("joint") if root.tag == "robot" else ():
        limit = joint.find("limit")
        # exporters write 0 where nobody knows, and a joint of no velocity is none
        if limit is not None and float(limit.get("velocity", 0.0)) > 0:
            found[joint.get("name")] = float(limit.attrib["velocity"])
    return np.array([found.get(name, np.inf) for name in joints])


def _torques(model: mujoco.MjModel, joints: Sequence[str]) -> np.ndarray:
    from t2l.sim.loop import torque_limits

    return np.abs(torque_limits(model, tuple(joints))).min(axis=1)


def home_of(path: Path, model: mujoco.MjModel, joints: Sequence[str]) -> np.ndarray:
    """(njoint,) rad of the first keyframe of a file, or zero, within the joints' ranges."""
    pose = {name: model.qpos0[model.joint(name).qposadr[0]] for name in joints}
    try:
        # the plant has no keyframes
        whole = mujoco.MjModel.from_xml_path(str(path))
    except ValueError:
        # meshes that only serve to draw are not there: no file with keyframes
        whole = model
    if whole.nkey:
        pose = {name: whole.key_qpos[0][whole.joint(name).qposadr[0]] for name in joints}
    return np.clip(list(pose.values()), *plant.position_ranges(model, joints).T)
