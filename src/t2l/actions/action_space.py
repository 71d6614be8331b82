"""What a policy's output means.

    x_des(t) = α ⊙ a(t) + γ β x(t) + γ (1 − β) x_des(t−1)

is the command that a controller gets for an action a (the study's footnote on environment shaping):
γ = 0 makes actions absolute; with γ = 1 they are relative to where the robot is (β = 1) or to the
command before (β = 0). An absolute action may be counted from the robot's home, so that a = 0 holds
it there. Solved for a, the equation labels demonstrations.
"""

from abc import ABC, abstractmethod
from collections.abc import Sequence
from copy import copy
from typing import ClassVar, Self

import numpy as np

from t2l.sim.arrays import Array, like, namespace


class ActionSpace(ABC):
    """Actions (n, naction) and the commands (n, ncommand) that a controller gets for them.

    Args:
        command_names: of the controller's commands.
        scale: α, one number, or one an element of an action.
        limits: (ncommand, 2) that commands are kept within; none without.
        reference: what actions are relative to, one of `references`; the first unless given.
        home: (ncommand,) the command at the robot's home, for the reference of that name.

    Attributes:
        name: what configurations write.
        controller: name of the controller whose commands it gives.
        references: what actions may be relative to: `measured` (γ = 1, β = 1), `commanded` (γ = 1,
            β = 0), `home` (γ = 0, counted from there); none where they are the command (γ = 0).
        names: of the elements of an action.
    """

    name: ClassVar[str]
    controller: ClassVar[str]
    references: ClassVar[tuple[str, ...]] = ()
    names: tuple[str, ...]

    def __init__(
        self,
        command_names: Sequence[str],
        scale: np.ndarray | float = 1.0,
        limits: np.ndarray | None = None,
        reference: str | None = None,
        home: np.ndarray | None = None,
    ):
        self.command_names, self.scale, self.limits = tuple(command_names), scale, limits
        self.reference = reference or next(iter(self.references), "")
        self._home = home

    def like(self, array: Array) -> Self:
        """The same space, for arrays such as `array`."""
        other = copy(self)
        other.scale, other.limits, other._home = (
            None if numbers is None else like(numbers, array)
            for numbers in (self.scale, self.limits, self._home)
        )
        return other

    def command(self, action: Array, measured: Array, before: Array) -> Array:
        """The command (n, ncommand) for an action, within the limits.

        Args:
            action: a, (n, naction).
            measured: x, (n, ncommand), where the robot is.
            before: x_des(t−1), (n, ncommand).
        """
        command = self.applied(self.scale * action, self._base(measured, before))
        if self.limits is None:
            return command
        return namespace(command).clip(command, self.limits[:, 0], self.limits[:, 1])

    def action(self, command: np.ndarray, measured: np.ndarray, before: np.ndarray) -> np.ndarray:
        """The action (n, naction) for a command, which demonstrations are labelled with."""
        return self.difference(command, self._base(measured, before)) / self.scale

    def memory(self, measured: Array, before: Array) -> Array:
        """(n, k) what of the past an action depends on, which a policy must therefore see.

        How far the command before lies from the robot, where actions are relative to that command;
        without columns where they are not.
        """
        if self.reference == "commanded":
            return self.difference(before, measured)
        return measured[:, :0]

    def _base(self, measured: Array, before: Array) -> Array:
        if self.reference == "home":
            return namespace(measured).broadcast_to(self._home, measured.shape)
        return measured if self.reference == "measured" else before

    @abstractmethod
    def applied(self, change: np.ndarray, base: np.ndarray) -> np.ndarray:
        """The command (n, ncommand) to which a scaled action leads, relative to `base`."""

    @abstractmethod
    def difference(self, command: np.ndarray, base: np.ndarray) -> np.ndarray:
        """The scaled action that leads to a command: the inverse of `applied`."""
