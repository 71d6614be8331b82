"""Dishrack unloading: a plate from a slot of the rack onto the pad."""

from typing import TYPE_CHECKING

import numpy as np

from t2l.tasks.dishrack import PAD, RACK, Dishrack
from t2l.tasks.plate import FOOT_HEIGHT, RADIUS

if TYPE_CHECKING:
    from scipy.spatial.transform import Rotation


class DishrackUnloading(Dishrack):
    """The plate leans in the middle slot and is laid on the pad; see `Dishrack`.

    The expert sets its far edge down and lets go, and it falls level: so close to the table a
    person would not hold it level either, for the hand that does so is 20 cm high.
    """

    name = "dishrack_unloading"
    instruction = "Take the plate out of the dish rack and lay it on the pad."
    origin, goal = RACK, PAD
    missed = "tipped"
    # from level, when it is let go; at less the hand comes too close to the table
    TILT_RAD = np.radians(40)
    # a plate that lies on anything but the pad is steeper, or not at its height
    LEVEL_RAD = np.radians(10)
    HEIGHT_TOLERANCE_M = 0.005

    def placed(self, position: np.ndarray, rotation: np.ndarray) -> np.ndarray:
        """It lies on the pad, the right way up."""
        height = self.plate_thickness_m / 2 + FOOT_HEIGHT
        return (rotation[:, 2, 2] > np.cos(self.LEVEL_RAD)) & (
            np.abs(position[:, 2] - height) < self.HEIGHT_TOLERANCE_M
        )

    def target(self, rng: np.random.Generator) -> "tuple[np.ndarray, Rotation]":
        from scipy.spatial.transform import Rotation

        # of the edge, just above the pad; the plate that falls about it lies in the middle
        edge = np.array([*rng.normal(0, 0.004, 2), 0.003]) - [0, RADIUS, 0]
        rotation = Rotation.from_euler("x", self.TILT_RAD + rng.normal(0, 0.05))
        return edge + rotation.apply([0, RADIUS, self.plate_thickness_m / 2]), rotation
