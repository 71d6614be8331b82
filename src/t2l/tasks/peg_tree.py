"""A tree of pegs that stands on the table; one peg, of another colour, is the one to use."""

from dataclasses import dataclass

import mujoco
import numpy as np

from t2l.tasks.mug import FRICTION

PLACE = (0.55, 0.28)  # on the table, m
HEIGHT, POST_RADIUS, FOOT_RADIUS = 0.26, 0.012, 0.07
PEG_LENGTH, PEG_HEIGHT = 0.13, 0.23
TILT = np.radians(10)  # of the pegs, upwards
# azimuth and height of the other pegs, out of the way of what hangs on the first
OTHERS = ((0.0, 0.15), (np.pi / 2, 0.23), (np.pi, 0.15))
_WOOD, _MARKED = (0.72, 0.53, 0.33, 1), (0.80, 0.20, 0.16, 1)


@dataclass(frozen=True)
class PegTree:
    """A foot, a post and four pegs.

    Attributes:
        peg_diameter_m: of every peg.
    """

    peg_diameter_m: float

    @property
    def peg(self) -> np.ndarray:
        """(2, 3) tip and root of the peg that is meant, m; it points to the robot's right."""
        return _peg(-np.pi / 2, PEG_HEIGHT)

    def add_to(self, spec: mujoco.MjSpec) -> None:
        """Put it into a scene, where nothing moves it."""
        world = spec.worldbody
        look = {"friction": FRICTION, "contype": 3, "conaffinity": 3}
        cylinder, capsule = mujoco.mjtGeom.mjGEOM_CYLINDER, mujoco.mjtGeom.mjGEOM_CAPSULE
        world.add_geom(
            name="foot", type=cylinder, size=(FOOT_RADIUS, 0.01, 0), pos=(*PLACE, 0.01),
            rgba=_WOOD, **look,
        )  # fmt: skip
        world.add_geom(
            name="post", type=capsule, size=(POST_RADIUS, 0, 0),
            fromto=(*PLACE, 0, *PLACE, HEIGHT - POST_RADIUS), rgba=_WOOD, **look,
        )  # fmt: skip
        pegs = [self.peg, *(_peg(azimuth, height) for azimuth, height in OTHERS)]
        for i, ends in enumerate(pegs):
            world.add_geom(
                name=f"peg_{i}", type=capsule, size=(self.peg_diameter_m / 2, 0, 0),
                fromto=ends.ravel(), rgba=_WOOD if i else _MARKED, **look,
            )  # fmt: skip


def _peg(azimuth: float, height: float) -> np.ndarray:
    root = np.array([*PLACE, height])
    level = np.cos(TILT)
    out = np.array([level * np.cos(azimuth), level * np.sin(azimuth), np.sin(TILT)])
    return np.stack([root + PEG_LENGTH * out, root])
