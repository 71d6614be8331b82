"""Controllers: laws that turn commands into torques at their own ticks."""

from t2l.registry import Registry
from t2l.sim.controllers.controller import Arm, Controller

CONTROLLERS: Registry[Controller] = Registry(
    "controller",
    Controller,
    {
        "joint_pd": "t2l.sim.controllers.joint_pd:JointPD",
        "operational_space_pd": "t2l.sim.controllers.operational_space:OperationalSpacePD",
    },
)

__all__ = ["CONTROLLERS", "Arm", "Controller"]
