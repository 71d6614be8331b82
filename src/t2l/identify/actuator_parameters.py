"""What identification adjusts at every actuator, and the space it is searched in.

Bounds are those of the study's table. The search runs in a box [0, 10] for every parameter, so
that one step size suits all: of stiffness and damping the logarithm (1 to 1024 by powers of two),
of the others the parameter itself.
"""

from collections.abc import Mapping

import numpy as np

from t2l.effects.effect import Parameter
from t2l.sim.training_simulator import Parameters

BOX = 10.0  # numerics: of each coordinate, so that one step of CMA-ES suits all

PARAMETERS = (
    Parameter("stiffness", "N·m/rad", 1.0, 1024.0, "torque by position error", log=True),
    Parameter("damping", "N·m·s/rad", 1.0, 1024.0, "torque by velocity, in the motor", log=True),
    Parameter("armature", "kg·m²", 0.0, 0.5, "rotor inertia seen at the joint"),
    Parameter("static_friction", "N·m", 0.01, 1.0, "largest torque that holds a joint at rest"),
    Parameter("dynamic_friction_ratio", "1", 0.0, 1.0, "friction in motion over that at rest"),
    Parameter("viscous_friction", "N·m·s/rad", 0.0, 1.0, "torque by velocity, in the joint"),
)


def decode(x: np.ndarray) -> Parameters:
    """Parameters of points x (n, 6 · njoint) in the box, by parameter and then by joint."""
    parts = np.split(np.asarray(x, float) / BOX, len(PARAMETERS), axis=-1)
    return {
        p.name: p.lower * (p.upper / p.lower) ** part
        if p.log
        else p.lower + (p.upper - p.lower) * part
        for p, part in zip(PARAMETERS, parts, strict=True)
    }


def encode(parameters: Mapping[str, np.ndarray]) -> np.ndarray:
    """Points (n, 6 · njoint) in the box; what lies outside is moved to its edge."""
    parts = []
    for p in PARAMETERS:
        value = np.clip(parameters[p.name], p.lower, p.upper)
        if p.log:
            parts.append(np.log(value / p.lower) / np.log(p.upper / p.lower))
        else:
            parts.append((value - p.lower) / (p.upper - p.lower))
    return BOX * np.concatenate(parts, axis=-1)


# numerics: of the range
def on_bound(parameters: Mapping[str, np.ndarray], margin: float = 0.01) -> list[tuple[str, int]]:
    """Names and joints of parameters (njoint,) within `margin` of the box's width of a bound."""
    x = encode({name: np.asarray(value)[None] for name, value in parameters.items()})[0] / BOX
    near = (x < margin) | (x > 1 - margin)
    njoint = len(x) // len(PARAMETERS)
    return [(PARAMETERS[i // njoint].name, i % njoint) for i in np.flatnonzero(near)]
