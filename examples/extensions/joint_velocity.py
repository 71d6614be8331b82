"""An action space of one's own: how fast each joint's target moves, in rad/s."""

from t2l.actions import ActionSpace

PERIOD_S = 0.02  # of a policy at 50 Hz


class JointVelocity(ActionSpace):
    """q_des(t) = q_des(t−1) + a · 20 ms."""

    name = "joint_velocity"
    controller = "joint_pd"
    references = ("commanded",)

    def __init__(self, command_names, scale=1.0, limits=None, reference=None):
        super().__init__(command_names, scale, limits, reference)
        self.names = tuple(name.replace("q_des", "dq_des", 1) for name in command_names)

    def applied(self, change, base):
        return base + PERIOD_S * change

    def difference(self, command, base):
        return (command - base) / PERIOD_S
