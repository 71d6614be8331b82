"""How a policy moves a robot: the controller of a cell, and the actions that command it."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import mujoco

from t2l.actions.action_space import ActionSpace
from t2l.actions.registry import ACTIONS
from t2l.gains import Cell
from t2l.robots import Robot
from t2l.sim.controllers import CONTROLLERS, Controller


@dataclass(frozen=True, eq=False)
class Control:
    """A controller with the gains of a cell, and what actions mean to it."""

    cell: Cell
    controller: Controller
    actions: ActionSpace


def make_control(
    section: Mapping[str, Any], cell: Cell, robot: Robot, model: mujoco.MjModel
) -> Control:
    """What the `actions` section of a checked configuration asks for, in a cell.

    Args:
        model: with the robot in it.

    Raises:
        ConfigurationError: there is no such action space.
    """
    parameters = dict(section)
    actions = ACTIONS.find(parameters.pop("kind"))
    law = CONTROLLERS.find(actions.controller)
    own = {name: parameters.pop(name) for name in law.settings if name in parameters}
    controller = law(model, robot.arms, cell.kp, cell.kd, **own)
    if "home" in actions.references:
        parameters["home"] = robot.home
    return Control(cell, controller, actions(controller.command_names, **parameters))
