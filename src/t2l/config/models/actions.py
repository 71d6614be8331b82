"""What the output of a policy means."""

from typing import Annotated, Literal

from pydantic import Field

from t2l.config.quantities import Given, Positive, Text
from t2l.typed import Typed


class Actions(Typed):
    """A kind of action space, and what it is relative to."""

    kind: Text = Field(
        "joint_target",
        description="`joint_target`: a position of each joint, rad; `joint_delta`: a change of it; "
        "`task_pose`: a pose of each tool, for operational-space control, with gains in 1/s² and "
        "1/s; `task_delta`: a change of it; or one of your own",
    )
    reference: Annotated[Literal["measured", "commanded", "home"] | None, Given] = Field(
        None,
        description="with a change: from what is `measured` (also without this key), from what "
        "was `commanded` before, or, of joints, from the robot's `home`",
    )


class RotationGains(Typed):
    """Of a tool's rotation, as factors of the cell's gains, which its translation has."""

    kp: Positive = Field(1.0, description="stiffness of rotation over that of translation")
    kd: Positive = Field(1.0, description="damping of rotation over that of translation")


class ClonedActions(Actions):
    """Of behaviour cloning."""

    rotation: Annotated[RotationGains | None, Given] = Field(
        None,
        description="under operational-space control, what gains the tool's rotation has; without "
        "it those of its translation",
    )


class RelativeActions(Actions):
    """Of reinforcement learning."""

    kind: Text = Field("joint_delta", description=Actions.model_fields["kind"].description)
