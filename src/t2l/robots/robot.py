"""What the rest of t2l knows of a robot: its model, its joints with all their limits, its tools."""

from abc import ABC, abstractmethod
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Self

import mujoco
import numpy as np
from numpy.typing import ArrayLike

from t2l.sim.controllers import Arm


@dataclass(frozen=True)
class Gripper:
    """Fingers that open and close by one command.

    Attributes:
        joints: of the fingers, the first of which tells how far they are.
        actuators: that take the command, all the same.
        closed, opened: the command at either end, in the actuators' unit.
        opened_qpos: of `joints` when opened.
        opening_m: between the fingertips when opened.
    """

    joints: tuple[str, ...]
    actuators: tuple[str, ...]
    closed: float
    opened: float
    opened_qpos: tuple[float, ...]
    opening_m: float

    def prefixed(self, prefix: str) -> Self:
        """The gripper of an arm whose names have a prefix."""
        joints, actuators = (
            tuple(prefix + name for name in names) for names in (self.joints, self.actuators)
        )
        return replace(self, joints=joints, actuators=actuators)


@dataclass(frozen=True)
class JointGroup:
    """Joints in a row from the base to one tool; each tuple has a number a joint.

    Attributes:
        name: `arm`, or `left` and `right`.
        joints: each driven by the actuator of the same name.
        proximal: how many of them, from the base, share an action scale; the rest share another.
        home: rad, the pose that starts are sampled around.
        velocity_limit: rad/s.
        torque_limit: N·m, on top of gravity compensation.
        torque_rate_limit: N·m/s, infinite where the maker states none.
        tool_site: site of the MJCF that a task moves; z is the approach direction.
        gripper: at the tool, if there is one.
        stiffness, damping: N·m/rad and N·m·s/rad, if gains of a cell are factors on them; without,
            gains of a cell are those of every joint.
    """

    name: str
    joints: tuple[str, ...]
    proximal: int
    home: tuple[float, ...]
    velocity_limit: tuple[float, ...]
    torque_limit: tuple[float, ...]
    torque_rate_limit: tuple[float, ...]
    tool_site: str
    gripper: Gripper | None = None
    stiffness: tuple[float, ...] = ()
    damping: tuple[float, ...] = ()

    def prefixed(self, prefix: str) -> Self:
        """The group of an arm whose names have a prefix, as MuJoCo attaches it."""
        return replace(
            self,
            joints=tuple(prefix + name for name in self.joints),
            tool_site=prefix + self.tool_site,
            gripper=self.gripper and self.gripper.prefixed(prefix),
        )


@dataclass(frozen=True)
class Walker:
    """What of a robot walks; joints and bodies by name.

    Attributes:
        base: the joint by which the robot floats, a MuJoCo free joint.
        height_m: of the base, where the robot stands at home on flat ground.
        feet: bodies that it walks on.
        trunk: the body that meets the ground in a fall alone.
        legs: joints that carry it, ankles left out.
        ankles: joints of the feet.
        sideways: joints of the legs that walking straight ahead does not need.
        arms, fingers, waist: other joints.
    """

    base: str
    height_m: float
    feet: tuple[str, ...]
    trunk: str
    legs: tuple[str, ...]
    ankles: tuple[str, ...]
    sideways: tuple[str, ...]
    arms: tuple[str, ...] = ()
    fingers: tuple[str, ...] = ()
    waist: tuple[str, ...] = ()


class Robot(ABC):
    """A position-controlled robot: one group of joints, or several, such as two arms.

    A subclass states `name` and `groups` and says where its MJCF is; limits of positions are the
    MJCF's ranges. Everything below is in the order of the groups.

    Attributes:
        name: what configurations write.
        groups: its joints, by tool.
        walker: its base and feet, if it walks.
        palm: site of the MJCF in the palm of a hand, z away from it, if it is a hand that stands
            still and things rest in.
    """

    name: str
    groups: tuple[JointGroup, ...]
    walker: Walker | None = None
    palm: str | None = None

    @abstractmethod
    def mjcf(self) -> Path:
        """The file that `bare` is made of.

        Raises:
            ConfigurationError: it is not installed; the message says what brings it.
        """

    def bare(self) -> mujoco.MjSpec:
        """The robot without tools, with the joints of `groups`: what the file says.

        A robot of several arms puts them together here.

        Raises:
            ConfigurationError: the file is not installed.
            ValueError: MuJoCo cannot read it.
        """
        return mujoco.MjSpec.from_file(str(self.mjcf()))

    @abstractmethod
    def spec(self, gravity_compensation: bool = True, visual: bool = False) -> mujoco.MjSpec:
        """The robot with its tools, to put a scene around.

        Each joint has a position actuator of its own name; geoms collide with what has bit 1.

        Args:
            gravity_compensation: whether the robot cancels its own gravity.
            visual: keep what only a renderer needs.

        Raises:
            ConfigurationError: files are not installed.
        """

    @cached_property
    def joints(self) -> tuple[str, ...]:
        """Names of all joints."""
        return tuple(joint for group in self.groups for joint in group.joints)

    @cached_property
    def arms(self) -> tuple[Arm, ...]:
        """The groups as controllers take them."""
        return tuple(
            Arm(group.joints, group.tool_site, np.array(group.home)) for group in self.groups
        )

    @cached_property
    def grippers(self) -> tuple[Gripper, ...]:
        """Of the groups that have one."""
        return tuple(group.gripper for group in self.groups if group.gripper)

    @cached_property
    def home(self) -> np.ndarray:
        """(njoint,) rad."""
        return self._joined("home")

    @cached_property
    def position_limit(self) -> np.ndarray:
        """(njoint, 2) rad, infinite where the MJCF states none."""
        from t2l.robots import plant

        model = plant.load(self.name, self.joints).compile()
        limits = plant.position_ranges(model, self.joints)
        limits.flags.writeable = False
        return limits

    @cached_property
    def velocity_limit(self) -> np.ndarray:
        """(njoint,) rad/s."""
        return self._joined("velocity_limit")

    @cached_property
    def torque_limit(self) -> np.ndarray:
        """(njoint,) N·m, on top of gravity compensation."""
        return self._joined("torque_limit")

    @cached_property
    def torque_rate_limit(self) -> np.ndarray:
        """(njoint,) N·m/s, infinite where none is stated."""
        return self._joined("torque_rate_limit")

    @cached_property
    def scale_groups(self) -> tuple[str, ...]:
        """Names of the groups of joints that share an action scale, as `scale_group` counts them.

        A robot with other groups than these overrides both.
        """
        return ("proximal", "distal") if not self.proximal.all() else ("proximal",)

    @cached_property
    def scale_group(self) -> np.ndarray:
        """(njoint,) which of `scale_groups` each joint is in."""
        return np.where(self.proximal, 0, 1)

    @cached_property
    def proximal(self) -> np.ndarray:
        """(njoint,) bool, which joints share the first action scale."""
        return np.concatenate(
            [np.arange(len(group.joints)) < group.proximal for group in self.groups]
        )

    def gains(self, kp: ArrayLike, kd: ArrayLike) -> tuple[np.ndarray, np.ndarray]:
        """Stiffness and damping of each joint, (…, njoint), N·m/rad and N·m·s/rad.

        Args:
            kp, kd: of a cell, one number or (…, 1).
        """
        return np.asarray(kp) * self._unit("stiffness"), np.asarray(kd) * self._unit("damping")

    def _unit(self, name: str) -> np.ndarray:
        """(njoint,) what gains of a cell are factors on."""
        units = [getattr(group, name) or np.ones(len(group.joints)) for group in self.groups]
        return np.concatenate(units)

    def _joined(self, name: str) -> np.ndarray:
        values = np.concatenate([getattr(group, name) for group in self.groups])
        values.flags.writeable = False
        return values
