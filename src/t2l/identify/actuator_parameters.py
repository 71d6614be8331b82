"""What identification adjusts at every actuator, and the space it is searched in.

Bounds are those of the study's table. The search runs in a box [0, 10] for every parameter, so
that one step size suits all: stiffness and damping are 2^x (1 to 1024), the others linear.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

BOX = 10.0


@dataclass(frozen=True)
class Bounds:
    """Of one parameter: unit, least and greatest value, and whether its logarithm is searched."""

    unit: str
    lower: float
    upper: float
    log: bool = False


TABLE: Mapping[str, Bounds] = {
    "stiffness": Bounds("N·m/rad", 1.0, 1024.0, log=True),
    "damping": Bounds("N·m·s/rad", 1.0, 1024.0, log=True),
    "armature": Bounds("kg·m²", 0.0, 0.5),
    "static_friction": Bounds("N·m", 0.01, 1.0),
    "dynamic_friction_ratio": Bounds("1", 0.0, 1.0),
    "viscous_friction": Bounds("N·m·s/rad", 0.0, 1.0),
}

Parameters = dict[str, np.ndarray]  # by name, (n, njoint) each


def decode(x: np.ndarray) -> Parameters:
    """Parameters of points x (n, 6 · njoint) in the box, by parameter and then by joint."""
    parts = np.split(np.asarray(x, float) / BOX, len(TABLE), axis=-1)
    return {
        name: bounds.lower * (bounds.upper / bounds.lower) ** part
        if bounds.log
        else bounds.lower + (bounds.upper - bounds.lower) * part
        for (name, bounds), part in zip(TABLE.items(), parts, strict=True)
    }


def encode(parameters: Mapping[str, np.ndarray]) -> np.ndarray:
    """Points (n, 6 · njoint) in the box; what lies outside is moved to its edge."""
    parts = []
    for name, bounds in TABLE.items():
        value = np.clip(parameters[name], bounds.lower, bounds.upper)
        if bounds.log:
            parts.append(np.log(value / bounds.lower) / np.log(bounds.upper / bounds.lower))
        else:
            parts.append((value - bounds.lower) / (bounds.upper - bounds.lower))
    return BOX * np.concatenate(parts, axis=-1)


def on_bound(parameters: Mapping[str, np.ndarray], margin: float = 0.01) -> list[tuple[str, int]]:
    """Names and joints of parameters (njoint,) within `margin` of the box's width of a bound."""
    x = encode({name: np.asarray(value)[None] for name, value in parameters.items()})[0] / BOX
    near = (x < margin) | (x > 1 - margin)
    njoint = len(x) // len(TABLE)
    names = list(TABLE)
    return [(names[i // njoint], i % njoint) for i in np.flatnonzero(near)]
