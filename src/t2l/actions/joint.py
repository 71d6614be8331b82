"""Actions in joint space, for the joint position controller."""

from typing import Literal

from pydantic import Field

from t2l.actions.action_space import ActionSpace
from t2l.typed import Typed

# relative to where the robot is, or to the command before: the study's β
References = Literal["measured", "commanded"]
RELATIVE_TO = Field(
    "measured",
    description="what actions are relative to: the position that is `measured`, or the one that "
    "was `commanded` before",
)


class JointTargetParameters(Typed):
    """Of absolute targets: nothing."""


class JointDeltaParameters(Typed):
    """Of relative targets."""

    reference: References = RELATIVE_TO


class JointTarget(ActionSpace):
    """An action is q_des itself, rad: γ = 0."""

    name = "joint_target"
    controller = "joint_pd"
    parameters = JointTargetParameters

    def __init__(self, command_names, scale=1.0, limits=None):
        super().__init__(command_names, scale, limits)
        self.names = self.command_names

    def applied(self, change, measured, before):
        """See `ActionSpace.applied`."""
        return change

    def difference(self, command, measured, before):
        """See `ActionSpace.difference`."""
        return command


class JointDelta(ActionSpace):
    """An action is how far q_des lies from q, or from the command before, rad: γ = 1.

    Args:
        reference: `measured` (β = 1) or `commanded` (β = 0).
    """

    name = "joint_delta"
    controller = "joint_pd"
    parameters = JointDeltaParameters

    def __init__(self, command_names, scale=1.0, limits=None, reference="measured"):
        super().__init__(command_names, scale, limits)
        self.names = tuple(name.replace("q_des", "delta", 1) for name in self.command_names)
        self._of_measured = reference == "measured"

    def applied(self, change, measured, before):
        """See `ActionSpace.applied`."""
        return (measured if self._of_measured else before) + change

    def difference(self, command, measured, before):
        """See `ActionSpace.difference`."""
        return command - (measured if self._of_measured else before)
