"""A plate of boxes: an octagon on a square foot."""

import mujoco
import numpy as np

from t2l.tasks.table_top import add_box

PLATE = "plate"
RADIUS, FOOT_HEIGHT, FOOT_HALF = 0.06, 0.004, 0.03  # m


def add_plate(spec: mujoco.MjSpec, thickness_m: float, mass_kg: float) -> None:
    """Put it into a scene, to move freely, with a site in its middle.

    Args:
        thickness_m, mass_kg: of the rim; of all of it.
    """
    plate = spec.worldbody.add_body(name=PLATE, pos=(0.5, 0, 0.5))
    plate.add_freejoint(name=PLATE)
    plate.add_site(name=PLATE, group=5)
    half, mass = thickness_m / 2, mass_kg / 5
    # four make the octagon; the one that is grasped and stands in the slot is a little larger, so
    # that it alone is touched and the simulation is a third faster
    across = np.array([RADIUS, RADIUS * np.tan(np.pi / 8), half])
    for i in range(4):
        size = across if i == 2 else 0.98 * across
        quat = (np.cos(i * np.pi / 8), 0, 0, np.sin(i * np.pi / 8))
        add_box(plate, f"rim_{i}", size, (0, 0, 0), (0.95, 0.95, 0.93, 1), mass, quat=quat)
    foot, below = (FOOT_HALF, FOOT_HALF, FOOT_HEIGHT / 2), (0, 0, -half - FOOT_HEIGHT / 2)
    add_box(plate, "foot", foot, below, (0.75, 0.76, 0.78, 1), mass)
