"""Actions in joint space, for the joint position controller."""

from t2l.actions.action_space import ActionSpace


class JointTarget(ActionSpace):
    """An action is q_des itself, rad: γ = 0."""

    name = "joint_target"
    controller = "joint_pd"

    def __init__(self, command_names, scale=1.0, limits=None):
        super().__init__(command_names, scale, limits)
        self.names = self.command_names

    def applied(self, change, base):
        """See `ActionSpace.applied`."""
        return change

    def difference(self, command, base):
        """See `ActionSpace.difference`."""
        return command


class JointDelta(ActionSpace):
    """An action is how far q_des lies from q, from the command before, or from home, rad."""

    name = "joint_delta"
    controller = "joint_pd"
    references = ("measured", "commanded", "home")

    def __init__(self, command_names, scale=1.0, limits=None, reference=None, home=None):
        super().__init__(command_names, scale, limits, reference, home)
        self.names = tuple(name.replace("q_des", "delta", 1) for name in self.command_names)

    def applied(self, change, base):
        """See `ActionSpace.applied`."""
        return base + change

    def difference(self, command, base):
        """See `ActionSpace.difference`."""
        return command - base
