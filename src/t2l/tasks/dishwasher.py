"""Dishwasher: grasp the bar on top of the door and pull the door open."""

from functools import cached_property
from typing import TYPE_CHECKING

import mujoco
import numpy as np
from mujoco.batch import Batch

from t2l.robots.specs import hold_at_rest
from t2l.tasks.dishwasher_parameters import DishwasherParameters
from t2l.tasks.door_monitor import DoorMonitor
from t2l.tasks.table_top import (
    MOVES,
    TableTop,
    add_box,
    add_furniture,
    check_graspable,
    check_range,
    furniture_joints,
)

if TYPE_CHECKING:
    from t2l.tasks.waypoints import Waypoint

# of a small dishwasher that stands on the table, m
WIDTH, DEPTH, THICKNESS, FEET = 0.45, 0.30, 0.02, 0.02
HINGE_HEIGHT, DOOR_HEIGHT = 0.08, 0.28
BAR_LENGTH, BAR_ABOVE_DOOR = 0.26, 0.05
DOOR_MASS_KG = 3.0
# what it takes to push the whole: 40 kg, half of which friction bears
PUSH_N, PUSH_NM = 200.0, 40.0
PLACE = furniture_joints("dishwasher")
DOOR, BAR = "door", "bar"


class Dishwasher(TableTop):
    """A robot with one gripper before a dishwasher whose door turns about its lower edge.

    A spring bears the weight of the door about as a real one does: it neither falls open nor shut.

    Args:
        robot, gravity_compensation, start_spread_rad, horizon_s: see `TableTop`.
        opened_rad: angle of the door from which on it counts as open.
        door_friction_nm: dry friction of the hinge.
        bar_diameter_m: of what is to be grasped; what is left of the gripper's opening is how
            far the hand may miss it.
        front_x_m, front_y_m: where the middle of the front stands at the start, (low, high).
        yaw_rad: the dishwasher starts turned by up to this much either way.

    Raises:
        ConfigurationError: no such robot.
        ValueError: the robot has not one arm with a gripper that opens wide enough; a range is
            empty.
    """

    name = "dishwasher"
    instruction = "Open the dishwasher."
    parameters = DishwasherParameters
    # from the side, where hand and door are both seen
    camera = global_camera = ((0.0, -1.2, 0.85), (0.94, -0.35, 0, 0.14, 0.37, 0.92))

    def __init__(
        self,
        robot: str,
        gravity_compensation: bool,
        opened_rad: float,
        door_friction_nm: float,
        bar_diameter_m: float,
        front_x_m: tuple[float, float],
        front_y_m: tuple[float, float],
        yaw_rad: float,
        start_spread_rad: float,
        horizon_s: float,
    ):
        super().__init__(robot, gravity_compensation, start_spread_rad, horizon_s)
        self.opened_rad = opened_rad
        self.door_friction_nm = door_friction_nm
        self.bar_diameter_m = bar_diameter_m
        self.front_x_m, self.front_y_m = tuple(front_x_m), tuple(front_y_m)
        self.yaw_rad = yaw_rad
        check_graspable("bar_diameter_m", bar_diameter_m, self.robot)
        for key in ("front_x_m", "front_y_m"):
            check_range(key, *getattr(self, key))

    @property
    def scene_names(self) -> tuple[str, ...]:
        return (
            "door.angle",
            *(f"bar.{c}" for c in "xyz"),
            *(f"bar.axis_{c}" for c in "xyz"),
            *(f"bar_from_grip.{c}" for c in "xyz"),
        )

    def spec(self, visual: bool) -> mujoco.MjSpec:
        spec = super().spec(visual)
        cabinet = add_furniture(spec, "dishwasher", 40, PUSH_N, PUSH_NM)
        height = HINGE_HEIGHT + DOOR_HEIGHT
        wall = THICKNESS / 2
        middle, half = (height + FEET) / 2, (height - FEET) / 2
        for name, size, pos in (
            ("left", (DEPTH / 2, wall, half), (DEPTH / 2, WIDTH / 2, middle)),
            ("right", (DEPTH / 2, wall, half), (DEPTH / 2, -WIDTH / 2, middle)),
            ("back", (wall, WIDTH / 2, half), (DEPTH, 0, middle)),
            ("top", (DEPTH / 2, WIDTH / 2, wall), (DEPTH / 2 + THICKNESS, 0, height - wall)),
        ):
            add_box(cabinet, name, size, pos, (0.75, 0.77, 0.80, 1))
        door = cabinet.add_body(name=DOOR, pos=(0, 0, HINGE_HEIGHT))
        weight = DOOR_MASS_KG * 9.81 * DOOR_HEIGHT / 2
        joint = door.add_joint(
            name=DOOR, type=mujoco.mjtJoint.mjJNT_HINGE, axis=(0, -1, 0), range=(0, np.pi / 2),
            limited=True, frictionloss=self.door_friction_nm, damping=0.5, stiffness=weight,
        )  # fmt: skip
        hold_at_rest(joint)
        panel = (wall, WIDTH / 2, DOOR_HEIGHT / 2)
        add_box(door, "panel", panel, (0, 0, DOOR_HEIGHT / 2), (0.60, 0.63, 0.68, 1), DOOR_MASS_KG)
        above = DOOR_HEIGHT + BAR_ABOVE_DOOR
        steel = (0.25, 0.27, 0.30, 1)
        for i, side in enumerate((-1, 1)):
            post = (0.006, 0.006, BAR_ABOVE_DOOR / 2)
            y = side * BAR_LENGTH / 2
            add_box(door, f"post_{i}", post, (0, y, above - post[2]), steel, 0.05)
        door.add_geom(
            name=BAR, type=mujoco.mjtGeom.mjGEOM_CAPSULE, mass=0.2, rgba=steel,
            fromto=(0, -BAR_LENGTH / 2, above, 0, BAR_LENGTH / 2, above),
            size=(self.bar_diameter_m / 2, 0, 0), **MOVES,
        )  # fmt: skip
        door.add_site(name=BAR, pos=(0, 0, above), size=(0.005, 0.005, 0.005), group=5)
        return spec

    def sample_starts(self, rng: np.random.Generator, n: int) -> np.ndarray:
        qpos = super().sample_starts(rng, n)
        low, high = np.transpose([self.front_x_m, self.front_y_m, (-self.yaw_rad, self.yaw_rad)])
        qpos[:, self._place] = rng.uniform(low, high, (n, 3))
        return qpos

    def door_angle(self, batch: Batch) -> np.ndarray:
        """(nsim,) rad."""
        return batch.bind("qpos")[:, self.model.joint(DOOR).qposadr[0]]

    def bar(self, batch: Batch) -> np.ndarray:
        """(nsim, 3) position of the bar's middle, m."""
        return batch.bind("site_xpos")[:, self._bar]

    def bar_axis(self, batch: Batch) -> np.ndarray:
        """(nsim, 3) the direction that the bar has."""
        return batch.bind("site_xmat")[:, self._bar].reshape(-1, 3, 3)[:, :, 1]

    def distance_from_bar(self, batch: Batch) -> np.ndarray:
        """(nsim,) m, from the tool to the bar's line."""
        return np.linalg.norm(
            np.cross(self.grip(batch) - self.bar(batch), self.bar_axis(batch)), axis=1
        )

    def observe(self, batch: Batch) -> np.ndarray:
        bar = self.bar(batch)
        return np.concatenate(
            [
                super().observe(batch),
                self.door_angle(batch)[:, None],
                bar,
                self.bar_axis(batch),
                bar - self.grip(batch),
            ],
            axis=1,
        )

    def waypoints(self, rng: np.random.Generator, qpos: np.ndarray) -> "list[list[Waypoint]]":
        """Before the bar, above it, down, grasp, pull on a circle; place, pace and pull vary."""
        # only an expert needs them, and SciPy's rotations take long to import
        from scipy.spatial.transform import Rotation

        from t2l.tasks.waypoints import POINTING_DOWN, Arc, Waypoint

        x, y, yaw = qpos[self._place]
        gripper, pace = self.robot.grippers[0], rng.uniform(0.85, 1.2)
        turned = Rotation.from_euler("z", yaw)
        hinge = np.array([x, y, HINGE_HEIGHT])
        where = [rng.normal(0, 0.002), rng.uniform(-0.06, 0.06), rng.normal(0, 0.002)]
        grasp = hinge + turned.apply([0, 0, DOOR_HEIGHT + BAR_ABOVE_DOOR]) + turned.apply(where)
        # the fingers open across the bar
        across = turned * Rotation.from_euler("z", np.pi / 2) * POINTING_DOWN
        approach = np.array([0, 0, rng.uniform(0.07, 0.10)])
        # over the bar, not against it
        before = approach + turned.apply([-0.12, 0, 0.02])
        held = Waypoint(grasp, across, pace * 0.3, gripper.closed)
        pull = turned.apply([0, -1, 0]) * (self.opened_rad + rng.uniform(0.1, 0.2))
        return [
            [
                Waypoint(grasp + before, across, pace * 1.1, gripper.opened),
                Waypoint(grasp + approach, across, pace * 0.5, gripper.opened),
                Waypoint(grasp, across, pace * 0.7, gripper.opened),
                held,
                Arc.after(held, across, pace * 2.5, hinge, pull),
            ]
        ]

    def monitor(self, nsim: int) -> DoorMonitor:
        return DoorMonitor(self, nsim)

    @cached_property
    def _bar(self) -> int:
        return self.model.site(BAR).id

    @cached_property
    def _place(self) -> list[int]:
        return [self.model.joint(name).qposadr[0] for name in PLACE]
