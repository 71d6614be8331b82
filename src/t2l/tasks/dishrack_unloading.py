"""Dishrack unloading: a plate from a slot of the rack onto the pad."""

from typing import TYPE_CHECKING

import numpy as np

from t2l.tasks.dishrack import FOOT_HEIGHT, PAD, RACK, RADIUS, Dishrack

if TYPE_CHECKING:
    from scipy.spatial.transform import Rotation


class DishrackUnloading(Dishrack):
    """The plate leans in the middle slot and is laid on the pad; see `Dishrack`."""

    name = "dishrack_unloading"
    instruction = "Take the plate out of the dish rack and lay it on the pad."
    origin, goal = RACK, PAD
    missed = "tipped"
    # a hand that lets go of it so is clear of the table, and it falls level
    TILT_RAD = np.radians(40)
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

        # its far edge is on the pad, as far from the middle as when the plate lies there
        edge = np.array([*rng.normal(0, 0.004, 2), 0.003]) - [0, RADIUS, 0]
        rotation = Rotation.from_euler("x", self.TILT_RAD + rng.normal(0, 0.05))
        return edge + rotation.apply([0, RADIUS, self.plate_thickness_m / 2]), rotation
