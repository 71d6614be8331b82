"""A plate, a rack with slots and a pad: what loading and unloading a dish rack share."""

from abc import abstractmethod
from functools import cached_property
from typing import TYPE_CHECKING

import mujoco
import numpy as np
from mujoco.batch import Batch

from t2l.tasks.dishrack_parameters import DishrackParameters
from t2l.tasks.plate import PLATE, RADIUS, add_plate
from t2l.tasks.plate_monitor import PlateMonitor
from t2l.tasks.poses import tilted
from t2l.tasks.table_top import (
    STANDS,
    TableTop,
    add_box,
    add_furniture,
    check_graspable,
    check_range,
    furniture_joints,
)

if TYPE_CHECKING:
    from scipy.spatial.transform import Rotation

    from t2l.tasks.waypoints import Waypoint

RACK, PAD = "rack", "pad"
# of the walls between slots, m: they reach the middle of a plate
WALL, WALL_HEIGHT, WALL_LENGTH = 0.004, 0.06, 0.12
# of the rack's floor and of the pad, m: where plates stand and lie; the pad is as wide as a plate
SURFACE, PAD_HALF = 0.01, 0.06
# from the lower edge of a plate to the wall it leans against, m: with less it may fall back
LEANS = 0.008
# what it takes to push rack or pad: 3 kg on rubber
MASS_KG, PUSH_N, PUSH_NM = 3.0, 30.0, 3.0
# between the middles of rack and pad, m: the hand is at one without touching the other
APART = 0.25
# from the rim to the tool that grasps it, m
GRASP_DEPTH = 0.008


class Dishrack(TableTop):
    """A robot with one gripper, a plate, a rack of three slots and a pad beside it.

    The plate leans in a slot, of the rack or of a holder on the pad. A hand grasps it from above
    by its rim, as a person does, and carries it in the plane of the fingers.

    Frames: the x of rack and pad is along the slots. The plate's z is its axis, upwards when it
    lies; its y leads outwards to the rim that is grasped, upwards when it stands.

    Args:
        robot, gravity_compensation, start_spread_rad, horizon_s: see `TableTop`.
        plate_thickness_m, plate_mass_kg: of the plate's rim; of all of it.
        slot_width_m: between two walls of the rack.
        rack_x_m, rack_y_m: where the middle of the rack is at the start, (low, high).
        pad_x_m, pad_y_m: where the middle of the pad is at the start, (low, high).
        yaw_rad: rack and pad start turned by up to this much either way, each by its own.

    Raises:
        ConfigurationError: no such robot.
        ValueError: the robot has not one arm with a gripper that opens wide enough; the plate
            does not fit into the slot; a range is empty; rack and pad are too close.

    Attributes:
        origin, goal: where the plate starts and where it goes, RACK or PAD.
        missed: the kind of failure of a plate that was let go at its goal, but not as it should.
    """

    parameters = DishrackParameters
    # close, and where one sees into the slots
    camera = ((1.15, -0.55, 0.55), (0.60, 0.80, 0, -0.29, 0.22, 0.93))
    origin: str
    goal: str
    missed: str

    def __init__(
        self,
        robot: str,
        gravity_compensation: bool,
        plate_thickness_m: float,
        plate_mass_kg: float,
        slot_width_m: float,
        rack_x_m: tuple[float, float],
        rack_y_m: tuple[float, float],
        pad_x_m: tuple[float, float],
        pad_y_m: tuple[float, float],
        yaw_rad: float,
        start_spread_rad: float,
        horizon_s: float,
    ):
        super().__init__(robot, gravity_compensation, start_spread_rad, horizon_s)
        self.plate_thickness_m = plate_thickness_m
        self.plate_mass_kg = plate_mass_kg
        self.slot_width_m = slot_width_m
        self.yaw_rad = yaw_rad
        self.ranges_m = {RACK: (rack_x_m, rack_y_m), PAD: (pad_x_m, pad_y_m)}
        check_graspable("plate_thickness_m", plate_thickness_m, self.robot)
        narrowest = plate_thickness_m + LEANS
        if slot_width_m < narrowest:
            raise ValueError(
                f"slot_width_m: found {slot_width_m:g}; allowed: from {narrowest:g} up, where a "
                f"plate of plate_thickness_m {plate_thickness_m:g} fits in"
            )
        for name, ranges in self.ranges_m.items():
            for axis, (low, high) in zip("xy", ranges, strict=True):
                check_range(f"{name}_{axis}_m", low, high)
        gaps = [
            max(a[0], b[0]) - min(a[1], b[1]) for a, b in zip(*self.ranges_m.values(), strict=True)
        ]
        if max(gaps) < APART:
            raise ValueError(
                f"rack_x_m, rack_y_m, pad_x_m, pad_y_m: found gaps of {gaps[0]:g} m and "
                f"{gaps[1]:g} m between rack and pad; allowed: at least {APART:g} m in x or y"
            )

    @abstractmethod
    def placed(self, position: np.ndarray, rotation: np.ndarray) -> np.ndarray:
        """(n,) bool, whether plates are as they should be, held or not.

        Args:
            position, rotation: (n, 3) m and (n, 3, 3), in the frame of the goal's surface.
        """

    @abstractmethod
    def target(self, rng: np.random.Generator) -> "tuple[np.ndarray, Rotation]":
        """Where an expert lets go of the plate, in the frame of the goal's surface."""

    @property
    def scene_names(self) -> tuple[str, ...]:
        return (
            *(f"plate.{c}" for c in "xyz"),
            *(f"plate.axis_{c}" for c in "xyz"),
            *(f"plate.outwards_{c}" for c in "xyz"),
            *(f"rim_from_grip.{c}" for c in "xyz"),
            *(f"{self.goal}.along_{c}" for c in "xy"),
            *(f"{self.goal}_from_plate.{c}" for c in "xyz"),
        )

    def spec(self, visual: bool) -> mujoco.MjSpec:
        spec = super().spec(visual)
        pitch = self.slot_width_m + WALL
        rack_base = (WALL_LENGTH / 2, (3 * pitch + WALL) / 2)
        self._add_surface(spec, RACK, rack_base, (0.55, 0.58, 0.63, 1), walls=4)
        # what a plate starts in is a holder of one slot
        walls = 2 if self.origin == PAD else 0
        self._add_surface(spec, PAD, (PAD_HALF, PAD_HALF), (0.36, 0.52, 0.60, 1), walls)
        add_plate(spec, self.plate_thickness_m, self.plate_mass_kg)
        return spec

    def _add_surface(
        self,
        spec: mujoco.MjSpec,
        name: str,
        half: tuple[float, float],
        colour: tuple[float, ...],
        walls: int,
    ) -> None:
        body = add_furniture(spec, name, MASS_KG, PUSH_N, PUSH_NM)
        body.add_site(name=name, pos=(0, 0, SURFACE), group=5)
        add_box(body, name, (*half, SURFACE / 2), (0, 0, SURFACE / 2), colour, **STANDS)
        size = (WALL_LENGTH / 2, WALL / 2, WALL_HEIGHT / 2)
        for i in range(walls):
            y = (i - (walls - 1) / 2) * (self.slot_width_m + WALL)
            pos = (0, y, SURFACE + WALL_HEIGHT / 2)
            add_box(body, f"{name}_wall_{i}", size, pos, (0.55, 0.58, 0.63, 1), **STANDS)

    def sample_starts(self, rng: np.random.Generator, n: int) -> np.ndarray:
        """The robot about its home, rack and pad somewhere, the plate leaning in its slot."""
        qpos = super().sample_starts(rng, n)
        turned = (-self.yaw_rad, self.yaw_rad)
        for name, (x, y) in self.ranges_m.items():
            low, high = np.transpose([x, y, turned])
            qpos[:, self._place[name]] = rng.uniform(low, high, (n, 3))

        # where its front stands between the walls; the farther back, the more it leans
        half, wall = self.plate_thickness_m / 2, self.slot_width_m / 2
        front = rng.uniform(2 * half - wall, wall - LEANS, n)
        lean = np.arctan((wall - front) / WALL_HEIGHT)
        along = rng.uniform(-0.01, 0.01, n)
        ahead = front + RADIUS * np.sin(lean) - half * np.cos(lean)
        x, y, yaw = qpos[:, self._place[self.origin]].T
        position = [
            x + np.cos(yaw) * along + np.sin(yaw) * ahead,
            y + np.sin(yaw) * along - np.cos(yaw) * ahead,
            SURFACE + RADIUS * np.cos(lean) + half * np.sin(lean),
        ]
        qpos[:, self.pose_of(PLATE)] = tilted(np.stack(position, axis=1), yaw, np.pi / 2 + lean)
        return qpos

    def plate_from_goal(self, batch: Batch) -> tuple[np.ndarray, np.ndarray]:
        """(nsim, 3) m and (nsim, 3, 3): of the plate, in the frame of the goal's surface."""
        (plate, axes), (goal, frame) = self._pose(batch, PLATE), self._pose(batch, self.goal)
        into = frame.transpose(0, 2, 1)
        return (into @ (plate - goal)[:, :, None])[:, :, 0], into @ axes

    def distance_from_grip(self, batch: Batch) -> np.ndarray:
        """(nsim,) m, from the tool to the plate's middle."""
        return np.linalg.norm(self._pose(batch, PLATE)[0] - self.grip(batch), axis=1)

    def observe(self, batch: Batch) -> np.ndarray:
        position, rotation = self._pose(batch, PLATE)
        goal, frame = self._pose(batch, self.goal)
        outwards = rotation[:, :, 1]
        rim = position + (RADIUS - GRASP_DEPTH) * outwards
        return np.concatenate(
            [
                super().observe(batch),
                position,
                rotation[:, :, 2],
                outwards,
                rim - self.grip(batch),
                frame[:, :2, 0],
                goal - position,
            ],
            axis=1,
        )

    def waypoints(self, rng: np.random.Generator, qpos: np.ndarray) -> "list[list[Waypoint]]":
        """Before the rim, at it, grasp, lift, carry and turn, down, let go, back.

        Where on the rim, heights, pace and where it is let go vary.
        """
        # only an expert needs them, and SciPy's rotations take long to import
        from scipy.spatial.transform import Rotation

        from t2l.tasks.waypoints import Waypoint

        gripper, pace = self.robot.grippers[0], rng.uniform(0.85, 1.2)
        opened, closed = gripper.opened, gripper.closed
        plate = qpos[self.pose_of(PLATE)]
        start = plate[:3], Rotation.from_quat(plate[3:], scalar_first=True)
        x, y, yaw = qpos[self._place[self.goal]]
        turned, (position, rotation) = Rotation.from_euler("z", yaw), self.target(rng)
        goal = turned.apply(position) + np.array([x, y, SURFACE]), turned * rotation
        # the hand comes against the plate's y, and its fingers open along z
        hand = Rotation.from_matrix([[1, 0, 0], [0, 0, -1], [0, 1, 0]])
        slip = [rng.normal(0, 0.004), rng.normal(0, 0.002), 0]
        rim = np.array([0, RADIUS - GRASP_DEPTH, 0]) + slip
        _, outwards, up = np.eye(3)
        approach, retreat, lift, lower = rng.uniform(
            [0.07, 0.08, 0.10, 0.08], [0.10, 0.11, 0.13, 0.11]
        )
        legs = [
            (start, approach, 0, 1.4, opened),
            (start, 0, 0, 0.7, opened),
            (start, 0, 0, 0.3, closed),
            (start, 0, lift, 0.7, closed),
            (goal, 0, lower, 1.7, closed),
            (goal, 0, 0, 0.8, closed),
            (goal, 0, 0, 0.2, opened),
            (goal, retreat, 0, 0.6, opened),
            (goal, retreat, 0, 0.3, opened),
        ]
        return [
            [
                Waypoint(
                    position + rotation.apply(rim + back * outwards) + above * up,
                    rotation * hand,
                    pace * duration,
                    command,
                )
                for (position, rotation), back, above, duration, command in legs
            ]
        ]

    def monitor(self, nsim: int) -> PlateMonitor:
        return PlateMonitor(self, nsim)

    @cached_property
    def plate_dofs(self) -> slice:
        """Of the plate's position in qvel."""
        address = self.model.joint(PLATE).dofadr[0]
        return slice(address, address + 3)

    def _pose(self, batch: Batch, name: str) -> tuple[np.ndarray, np.ndarray]:
        """(nsim, 3) and (nsim, 3, 3): of PLATE, or of the surface of RACK or PAD."""
        site = self._sites[name]
        rotation = batch.bind("site_xmat")[:, site].reshape(-1, 3, 3)
        return batch.bind("site_xpos")[:, site], rotation

    @cached_property
    def _place(self) -> dict[str, list[int]]:
        return {
            name: [self.model.joint(joint).qposadr[0] for joint in furniture_joints(name)]
            for name in (RACK, PAD)
        }

    @cached_property
    def _sites(self) -> dict[str, int]:
        return {name: self.model.site(name).id for name in (PLATE, RACK, PAD)}
