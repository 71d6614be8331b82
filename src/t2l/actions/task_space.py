"""Actions in task space, for the operational-space controller.

A pose in a command is a position and a rotation matrix by rows. In an absolute action the rotation
is its first two rows, from which the third follows (Zhou et al. 2019, "On the continuity of
rotation representations in neural networks", section 4); in a relative one it is a rotation vector
in the world's frame.
"""

import numpy as np
from scipy.spatial.transform import Rotation

from t2l.actions.action_space import ActionSpace

# numbers in a pose of a command, and in an absolute and a relative action for it
POSE, ABSOLUTE, RELATIVE = 12, 9, 6


class TaskPose(ActionSpace):
    """An action is each tool's pose: position in m, and two rows of its rotation."""

    name = "task_pose"
    controller = "operational_space_pd"

    def __init__(self, command_names, scale=1.0, limits=None):
        super().__init__(command_names, scale, limits)
        self.names = tuple(name for i, name in enumerate(self.command_names) if i % POSE < ABSOLUTE)

    def applied(self, change, base):
        """See `ActionSpace.applied`: rows made orthonormal by Gram and Schmidt."""
        parts = change.reshape(len(change), -1, ABSOLUTE)
        first = _unit(parts[:, :, 3:6])
        second = parts[:, :, 6:9]
        second = _unit(second - (first * second).sum(axis=2, keepdims=True) * first)
        poses = [parts[:, :, :3], first, second, np.cross(first, second)]
        return np.concatenate(poses, axis=2).reshape(len(change), -1)

    def difference(self, command, base):
        """See `ActionSpace.difference`."""
        return command.reshape(len(command), -1, POSE)[:, :, :ABSOLUTE].reshape(len(command), -1)


class TaskDelta(ActionSpace):
    """An action is how far each tool's desired pose lies from its pose, or from the one before."""

    name = "task_delta"
    controller = "operational_space_pd"
    references = ("measured", "commanded")

    def __init__(self, command_names, scale=1.0, limits=None, reference=None):
        super().__init__(command_names, scale, limits, reference)
        sites = dict.fromkeys(name.rpartition(".")[0] for name in self.command_names)
        axes = ("x", "y", "z", "rx", "ry", "rz")
        self.names = tuple(
            f"{site.replace('x_des', 'delta', 1)}.{a}" for site in sites for a in axes
        )

    def applied(self, change, base):
        """See `ActionSpace.applied`."""
        n = len(change)
        parts, base = change.reshape(n, -1, RELATIVE), base.reshape(n, -1, POSE)
        turn = Rotation.from_rotvec(parts[:, :, 3:].reshape(-1, 3)).as_matrix()
        rotation = turn @ base[:, :, 3:].reshape(-1, 3, 3)
        position = base[:, :, :3] + parts[:, :, :3]
        return np.concatenate([position, rotation.reshape(n, -1, 9)], axis=2).reshape(n, -1)

    def difference(self, command, base):
        """See `ActionSpace.difference`."""
        n = len(command)
        there, base = command.reshape(n, -1, POSE), base.reshape(n, -1, POSE)
        rotation, here = (p[:, :, 3:].reshape(-1, 3, 3) for p in (there, base))
        turn = Rotation.from_matrix(rotation @ here.transpose(0, 2, 1)).as_rotvec()
        position = there[:, :, :3] - base[:, :, :3]
        return np.concatenate([position, turn.reshape(n, -1, 3)], axis=2).reshape(n, -1)


def _unit(vectors: np.ndarray) -> np.ndarray:
    return vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)
