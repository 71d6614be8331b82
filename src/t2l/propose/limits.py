"""Limits of the motor torque as laws: straight lines over the velocity.

A limit that is never reached does nothing, so no small change of it tells what it would do. Its
dictionary has whole limits instead of small torques, and the fit begins at one of them.
"""

import numpy as np

from t2l.effects.law import Law
from t2l.effects.spline_torque import SplineTorque
from t2l.propose.bases import MARGIN

# numerics: of the samples, those in which an atom is at its limit, a factor of three apart
SHARES = (0.003, 0.01, 0.03, 0.1, 0.3)
# numerics: of an atom's slope, in parts of the greatest torque over the greatest speed
SLOPES = (0.0, 0.3, 1.0, 3.0)


def limit_of(law: Law, torque: np.ndarray, dq: np.ndarray, size: float) -> SplineTorque:
    """A limit over the velocity, whose weights are its values at both ends.

    What a motor gives at a velocity at which it is never at its limit, no recording tells: so it is
    a straight line, as of a motor of direct current, and no curve.

    Args:
        torque, dq: (nsample,) of the joint, commanded N·m and predicted rad/s.
        size: as of `SplineTorque`.
    """
    fastest = (1 + MARGIN) * np.abs(dq).max()
    grid = np.array([-fastest, fastest])
    atoms = []
    for slope in SLOPES:
        slope *= np.abs(torque).max() / fastest
        # N·m at rest that the motor needs for it
        needed = np.abs(torque) + slope * dq * np.sign(torque)
        atoms += [level - slope * grid for level in np.quantile(needed, 1 - np.array(SHARES))]
    return SplineTorque(law, grid, np.eye(2), size, atoms=np.stack(atoms))
