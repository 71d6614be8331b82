"""Which action spaces there are."""

from t2l.actions.action_space import ActionSpace
from t2l.registry import Registry

ACTIONS: Registry[ActionSpace] = Registry(
    "action space",
    ActionSpace,
    {
        "joint_target": "t2l.actions.joint:JointTarget",
        "joint_delta": "t2l.actions.joint:JointDelta",
        "task_pose": "t2l.actions.task_space:TaskPose",
        "task_delta": "t2l.actions.task_space:TaskDelta",
    },
)
