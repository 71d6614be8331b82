"""One pair of controller gains: the unit that every stage is cached by."""

import re
from dataclasses import dataclass

import numpy as np

NAME_PATTERN = r"kp[0-9.]+_kd[0-9.]+"


@dataclass(frozen=True, order=True)
class Cell:
    """Stiffness kp [N·m/rad] and damping kd [N·m·s/rad], the same on every arm joint.

    Raises:
        ValueError: a gain is not a finite number above zero.
    """

    kp: float
    kd: float

    def __post_init__(self) -> None:
        for key, value in (("kp", self.kp), ("kd", self.kd)):
            if not 0 < value < float("inf"):
                raise ValueError(f"{key} must be a finite number above 0, found {value!r}")

    @property
    def name(self) -> str:
        """The cell in paths, ``kp16_kd24``."""
        return f"kp{_plain(self.kp)}_kd{_plain(self.kd)}"

    @classmethod
    def from_name(cls, name: str) -> "Cell":
        """The cell that a path names.

        Raises:
            ValueError: the name is not of the form ``kp16_kd24``.
        """
        match = re.fullmatch(r"kp([0-9.]+)_kd([0-9.]+)", name)
        if match is None:
            raise ValueError(f"{name!r} names no cell; expected a name such as kp16_kd24")
        return cls(kp=float(match[1]), kd=float(match[2]))

    def __str__(self) -> str:
        return f"Kp {_plain(self.kp)}, Kd {_plain(self.kd)}"


def _plain(value: float) -> str:
    # the shortest digits that are exact, so a name always leads back to the same gains
    return np.format_float_positional(float(value), trim="-")
