"""Where a task's `kind` in config/tasks/ becomes a class."""

from collections.abc import Mapping
from typing import Any

from t2l.registry import Registry
from t2l.tasks.task import Task

TASKS: Registry[Task] = Registry(
    "task",
    Task,
    {
        "block_stack": "t2l.tasks.block_stack:BlockStack",
        "bimanual_handover": "t2l.tasks.bimanual_handover:BimanualHandover",
        "dishrack_loading": "t2l.tasks.dishrack_loading:DishrackLoading",
        "dishrack_unloading": "t2l.tasks.dishrack_unloading:DishrackUnloading",
        "dishwasher": "t2l.tasks.dishwasher:Dishwasher",
        "mug_hanging": "t2l.tasks.mug_hanging:MugHanging",
        "joint_reach": "t2l.tasks.reach:JointReach",
        "end_effector_reach": "t2l.tasks.reach:EndEffectorReach",
        "lift_cube": "t2l.tasks.lift_cube:LiftCube",
        "open_drawer": "t2l.tasks.open_drawer:OpenDrawer",
        "track_velocity": "t2l.tasks.track_velocity:TrackVelocity",
        "reorient_cube": "t2l.tasks.reorient_cube:ReorientCube",
        "in_hand_cube": "t2l.tasks.in_hand_cube:InHandCube",
        "pose_hold": "t2l.tasks.pose_hold:PoseHold",
    },
)


def make_task(parameters: Mapping[str, Any]) -> Task:
    """The task that a validated file of config/tasks/ describes.

    Raises:
        ConfigurationError: its robot is not known or not installed.
    """
    parameters = dict(parameters)
    return TASKS.find(parameters.pop("kind"))(**parameters)
