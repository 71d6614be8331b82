"""What the output of a policy means."""

from typing import Annotated, Literal

from pydantic import Field

from t2l.config.quantities import Given, Text
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


class RelativeActions(Actions):
    """Of reinforcement learning."""

    kind: Text = Field("joint_delta", description=Actions.model_fields["kind"].description)
