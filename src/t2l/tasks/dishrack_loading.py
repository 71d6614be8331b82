"""Dishrack loading: a plate from a holder into a slot of the rack."""

from typing import TYPE_CHECKING

import numpy as np

from t2l.tasks.dishrack import PAD, RACK, WALL_LENGTH, Dishrack
from t2l.tasks.plate import RADIUS

if TYPE_CHECKING:
    from scipy.spatial.transform import Rotation


class DishrackLoading(Dishrack):
    """The plate leans in a holder on the pad and is put into the middle slot; see `Dishrack`.

    In a holder, not flat: fingers can get at its rim from above, and what is hard is the slot.
    """

    name = "dishrack_loading"
    instruction = "Put the plate into the middle slot of the dish rack."
    origin, goal = PAD, RACK
    missed = "beside_slot"
    # a plate that leans against a wall of its slot is upright
    UPRIGHT_RAD = np.radians(30)

    def placed(self, position: np.ndarray, rotation: np.ndarray) -> np.ndarray:
        """Upright, its lowest edge in the slot."""
        axis = rotation[:, :, 2]
        # down, along the plate
        down = axis[:, 2:] * axis - [0, 0, 1]
        length = np.linalg.norm(down, axis=1, keepdims=True)
        edge = position + RADIUS * down / np.maximum(length, 1e-9)
        return (
            (length[:, 0] > np.cos(self.UPRIGHT_RAD))
            & (np.abs(edge[:, 1]) < self.slot_width_m / 2)
            & (np.abs(position[:, 0]) < WALL_LENGTH / 2)
            & (np.abs(edge[:, 2]) < 0.01)
        )

    def target(self, rng: np.random.Generator) -> "tuple[np.ndarray, Rotation]":
        from scipy.spatial.transform import Rotation

        position = [rng.normal(0, 0.006), rng.normal(0, 0.0015), RADIUS + 0.004]
        return np.array(position), Rotation.from_euler("x", np.pi / 2 + rng.normal(0, 0.02))
