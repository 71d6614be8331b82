"""A mug of boxes: eight flat walls, a bottom, and a handle of three bars."""

from dataclasses import dataclass

import mujoco
import numpy as np

HEIGHT, WALL, BOTTOM = 0.09, 0.004, 0.006
BAR = 0.008  # how thick the handle is, m
BAR_WIDTH = 0.012
HANDLE_HEIGHT = 0.010  # of the handle's middle above the mug's middle, m
DENSITY = 2400.0  # of stoneware, kg/m³
# of a glaze on wood; of two geoms MuJoCo takes the larger, so fingers of rubber hold it well
FRICTION = (0.4, 0.005, 0.0001)
NAME, HANDLE = "mug", "handle"
_GLAZE = (0.16, 0.36, 0.75, 1)


@dataclass(frozen=True)
class Mug:
    """Its frame is in its middle: z upwards, the handle along x.

    Attributes:
        diameter_m: across two flat sides.
        opening_m: edge of the square that the handle leaves open.
    """

    diameter_m: float
    opening_m: float

    @property
    def handle(self) -> np.ndarray:
        """(3,) the middle of the handle's opening, m."""
        return np.array([(self.diameter_m + self.opening_m) / 2, 0, HANDLE_HEIGHT])

    @property
    def reach_m(self) -> float:
        """From the middle of the mug to what of it is farthest away."""
        half = self.opening_m / 2
        handle = self.handle + np.array([half + BAR, BAR_WIDTH / 2, half + BAR])
        rim = np.array([self.diameter_m / 2, self._side, HEIGHT / 2])
        return float(np.linalg.norm([handle, rim], axis=1).max())

    @property
    def _side(self) -> float:
        """Half the width of a wall, m."""
        return self.diameter_m / 2 * np.tan(np.pi / 8)

    def add_to(self, spec: mujoco.MjSpec) -> None:
        """Put it into a scene, to move freely, with a site in the handle's opening."""
        body = spec.worldbody.add_body(name=NAME, pos=(0.5, 0, HEIGHT / 2))
        body.add_freejoint(name=NAME)
        for name, half, position, yaw in self._boxes():
            body.add_geom(
                name=f"{NAME}_{name}", type=mujoco.mjtGeom.mjGEOM_BOX, size=half, pos=position,
                quat=(np.cos(yaw / 2), 0, 0, np.sin(yaw / 2)), density=DENSITY, friction=FRICTION,
                rgba=_GLAZE, contype=3, conaffinity=3,
            )  # fmt: skip
        body.add_site(name=HANDLE, pos=self.handle, size=(0.005, 0.005, 0.005), group=5)

    def _boxes(self) -> list[tuple]:
        """(name, half sizes, position, yaw) of each."""
        radius = self.diameter_m / 2
        # walls end above the underside, so that four contacts with a table bear the mug, not 36
        wall = (WALL / 2, self._side, (HEIGHT - BOTTOM / 2) / 2)
        boxes = [
            (
                f"wall_{i}",
                wall,
                ((radius - WALL / 2) * np.cos(yaw), (radius - WALL / 2) * np.sin(yaw), BOTTOM / 4),
                yaw,
            )
            for i, yaw in enumerate(np.arange(8) * np.pi / 4)
        ]
        # a square within the walls
        plate = (radius - WALL) / np.sqrt(2)
        boxes.append(("bottom", (plate, plate, BOTTOM / 2), (0, 0, (BOTTOM - HEIGHT) / 2), 0.0))
        x, _, z = self.handle
        half, bar = self.opening_m / 2, BAR / 2
        level = (half + bar, BAR_WIDTH / 2, bar)
        return [
            *boxes,
            ("upper_bar", level, (x + bar, 0, z + half + bar), 0.0),
            ("lower_bar", level, (x + bar, 0, z - half - bar), 0.0),
            ("outer_bar", (bar, BAR_WIDTH / 2, half), (x + half + bar, 0, z), 0.0),
        ]
