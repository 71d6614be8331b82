"""What passes between a policy and a robot, simulated or not."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from t2l.actions import ACTIONS, ActionSpace
from t2l.actions.gripper import BinaryGrippers
from t2l.errors import ConfigurationError
from t2l.robots import Robot
from t2l.sim.arrays import Array, namespace
from t2l.sim.controllers.joint_pd import COMMAND_PREFIX
from t2l.tasks import Rewarded
from t2l.tasks.terms import Moment


def observe(at: Moment, memory: Array) -> Array:
    """What a policy sees, (n, nobs) float32: its task's terms, and its last action.

    Args:
        memory: what else its next action depends on, see `ActionSpace.memory`.
    """
    xp = namespace(at.q)
    return xp.astype(xp.concat([at.task.observe(at), at.action, memory], axis=1), xp.float32)


def observation_names(task: Rewarded, actions: ActionSpace | None = None) -> list[str]:
    """Names of an observation's columns, those of the actions' memory among them."""
    joints = task.robot.joints
    remembers = actions is not None and actions.reference == "commanded"
    last = [*joints, *BinaryGrippers(task.commanded_grippers).names]
    ahead = [f"ahead.{joint}" for joint in joints] if remembers else []
    return [*task.observation_names, *(f"action.{name}" for name in last), *ahead]


def steps_held(rate_hz: float, policy_rate_hz: float, of_what: str) -> int:
    """How many steps at `rate_hz` an action is held for.

    Raises:
        ConfigurationError: no whole number of them.
    """
    steps = rate_hz / policy_rate_hz
    if abs(steps - round(steps)) > 1e-9:
        raise ConfigurationError(
            f"policy rate: found {policy_rate_hz:g} Hz; allowed: a divisor of {of_what} "
            f"{rate_hz:g} Hz"
        )
    return round(steps)


def scale_per_joint(action_scale: tuple[float, ...], robot: Robot) -> np.ndarray:
    """(njoint,) rad: α of each joint, from those of `Robot.scale_groups`.

    Raises:
        ConfigurationError: not one number above 0 for each group.
    """
    groups = robot.scale_groups
    if len(action_scale) != len(groups) or not all(0 < scale < np.inf for scale in action_scale):
        raise ConfigurationError(
            f"action scale: found {list(action_scale)}; allowed: a number above 0 for each of "
            f"{', '.join(groups)}"
        )
    return np.array(action_scale, float)[robot.scale_group]


def action_space(actions: Mapping[str, Any], robot: Robot, scale: np.ndarray) -> ActionSpace:
    """What actions mean to the robot's joints.

    Commands stay within the joints' ranges: soft gains take them far ahead of the arm, and no robot
    accepts what lies beyond.

    Args:
        actions: that section of a checked configuration.
        scale: α, (njoint,) rad.

    Raises:
        ConfigurationError: there is no such action space.
    """
    section = dict(actions)
    names = [f"{COMMAND_PREFIX}{joint}" for joint in robot.joints]
    space = ACTIONS.find(section.pop("kind"))
    if "home" in space.references:
        section["home"] = robot.home
    return space(names, scale, robot.position_limit, **section)
