"""What an action means to grippers."""

from collections.abc import Sequence

import numpy as np

from t2l.robots.robot import Gripper
from t2l.sim.arrays import Array, like, namespace


class BinaryGrippers:
    """An element of an action for each gripper: below 0 closes it, all else opens it.

    The study's (App. E), and IsaacLab's `BinaryJointPositionAction`. No scale acts on it.

    Attributes:
        names: of the elements of an action.
    """

    def __init__(self, grippers: Sequence[Gripper]):
        self.names = tuple(f"open.{gripper.joints[0]}" for gripper in grippers)
        self._closed = np.array([gripper.closed for gripper in grippers])
        self._opened = np.array([gripper.opened for gripper in grippers])

    def command(self, action: Array) -> Array:
        """(n, ngripper) commands for elements of an action (n, ngripper)."""
        closed, opened = (like(end, action) for end in (self._closed, self._opened))
        return namespace(action).where(action < 0, closed, opened)
