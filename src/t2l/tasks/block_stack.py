"""Block Stack: pick up the red block and leave it standing on the blue one."""

from typing import TYPE_CHECKING

import mujoco
import numpy as np
from mujoco.batch import Batch

from t2l.tasks.block_stack_parameters import BlockStackParameters
from t2l.tasks.poses import position_and_axes, upright
from t2l.tasks.stack_monitor import StackMonitor
from t2l.tasks.table_top import TableTop, add_cube, check_graspable, check_range

if TYPE_CHECKING:
    from t2l.tasks.waypoints import Waypoint

BLOCKS = ("red_block", "blue_block")
_COLOURS = ((0.80, 0.20, 0.16, 1), (0.16, 0.36, 0.75, 1))


class BlockStack(TableTop):
    """A robot with one gripper at a table with two cubes.

    Args:
        robot, gravity_compensation, start_spread_rad, horizon_s: see `TableTop`.
        block_size_m: edge of both cubes.
        block_mass_kg: mass of each.
        placement_tolerance_m: largest horizontal distance between the blocks' centres that
            counts as stacked.
        workspace_x_m, workspace_y_m: where blocks start, (low, high).
        block_yaw_rad: blocks start turned by up to this much either way.

    Raises:
        ConfigurationError: no such robot.
        ValueError: the robot's gripper does not open wide enough; a workspace range is empty, or
            too small for the blocks to lie apart.
    """

    name = "block_stack"
    instruction = "Pick up the red block and stack it on the blue block."
    parameters = BlockStackParameters

    def __init__(
        self,
        robot: str,
        gravity_compensation: bool,
        block_size_m: float,
        block_mass_kg: float,
        placement_tolerance_m: float,
        workspace_x_m: tuple[float, float],
        workspace_y_m: tuple[float, float],
        block_yaw_rad: float,
        start_spread_rad: float,
        horizon_s: float,
    ):
        super().__init__(robot, gravity_compensation, start_spread_rad, horizon_s)
        self.block_size_m = block_size_m
        self.block_mass_kg = block_mass_kg
        self.placement_tolerance_m = placement_tolerance_m
        self.workspace_x_m = tuple(workspace_x_m)
        self.workspace_y_m = tuple(workspace_y_m)
        self.block_yaw_rad = block_yaw_rad
        check_graspable("block_size_m", block_size_m, self.robot)
        for key in ("workspace_x_m", "workspace_y_m"):
            check_range(key, *getattr(self, key))
        width, depth = np.ptp([self.workspace_x_m, self.workspace_y_m], axis=1)
        if np.hypot(width, depth) < 1.5 * self.block_gap_m:
            raise ValueError(
                f"workspace_x_m, workspace_y_m: found {width:g} m by {depth:g} m; allowed: a "
                f"diagonal of at least {1.5 * self.block_gap_m:g} m, so that the blocks lie apart"
            )

    @property
    def scene_names(self) -> tuple[str, ...]:
        axes = [f"axis{i}_{c}" for i in (1, 2) for c in "xyz"]
        return (
            *(f"{block}.{name}" for block in BLOCKS for name in (*"xyz", *axes)),
            *(f"{BLOCKS[0]}_from_grip.{c}" for c in "xyz"),
            *(f"{BLOCKS[1]}_from_{BLOCKS[0]}.{c}" for c in "xyz"),
        )

    @property
    def block_gap_m(self) -> float:
        """Smallest distance of the blocks' centres at the start: the fingers fit in between."""
        return 2.5 * self.block_size_m

    def spec(self, visual: bool) -> mujoco.MjSpec:
        spec = super().spec(visual)
        for name, colour in zip(BLOCKS, _COLOURS, strict=True):
            add_cube(spec, name, self.block_size_m, self.block_mass_kg, colour)
        return spec

    def sample_starts(self, rng: np.random.Generator, n: int) -> np.ndarray:
        qpos = super().sample_starts(rng, n)
        positions = np.empty((n, 2, 2))
        missing = np.ones(n, dtype=bool)
        while missing.any():
            low, high = np.transpose([self.workspace_x_m, self.workspace_y_m])
            positions[missing] = rng.uniform(low, high, (missing.sum(), 2, 2))
            gap = np.linalg.norm(positions[:, 0] - positions[:, 1], axis=1)
            missing = gap < self.block_gap_m
        yaws = rng.uniform(-self.block_yaw_rad, self.block_yaw_rad, (n, 2))
        height = np.full((n, 1), self.block_size_m / 2)
        for i, name in enumerate(BLOCKS):
            centre = np.concatenate([positions[:, i], height], axis=1)
            qpos[:, self.pose_of(name)] = upright(centre, yaws[:, i])
        return qpos

    def block_poses(self, qpos: np.ndarray) -> np.ndarray:
        """(..., 2, 7) position and quaternion of the red and the blue block."""
        return np.stack([qpos[..., self.pose_of(name)] for name in BLOCKS], axis=-2)

    def observe(self, batch: Batch) -> np.ndarray:
        poses = self.block_poses(batch.bind("qpos"))
        red, blue = poses[:, 0, :3], poses[:, 1, :3]
        return np.concatenate(
            [
                super().observe(batch),
                *(position_and_axes(poses[:, i]) for i in range(2)),
                red - self.grip(batch),
                blue - red,
            ],
            axis=1,
        )

    def waypoints(self, rng: np.random.Generator, qpos: np.ndarray) -> "list[list[Waypoint]]":
        """Above red, down, grasp, lift, above blue, down, let go, up; heights, pace, grip vary."""
        # only an expert needs them, and SciPy's rotations take long to import
        from scipy.spatial.transform import Rotation

        from t2l.tasks.waypoints import POINTING_DOWN, Waypoint

        red, blue = self.block_poses(qpos)
        size, gripper = self.block_size_m, self.robot.grippers[0]
        opened, closed = gripper.opened, gripper.closed
        pace = rng.uniform(0.85, 1.2)
        slip = np.array([*rng.normal(0, 0.003, 2), rng.uniform(-0.1, 0.15) * size])
        red_rotation, blue_rotation = (
            Rotation.from_quat(pose[3:], scalar_first=True) * POINTING_DOWN for pose in (red, blue)
        )
        grasp = red[:3] + slip
        place = blue[:3] + slip + [0, 0, size + 0.002]
        approach, lift, carry, retreat = rng.uniform(
            [0.08, 0.10, 0.07, 0.08], [0.14, 0.16, 0.11, 0.12]
        )[:, None] * np.array([0, 0, 1])
        legs = [
            (grasp + approach, red_rotation, 1.0, opened),
            (grasp, red_rotation, 0.6, opened),
            (grasp, red_rotation, 0.25, closed),
            (grasp + lift, red_rotation, 0.5, closed),
            (place + carry, blue_rotation, 1.0, closed),
            (place, blue_rotation, 0.6, closed),
            (place, blue_rotation, 0.15, opened),
            (place + retreat, blue_rotation, 0.5, opened),
            (place + retreat, blue_rotation, 0.3, opened),
        ]
        return [
            [
                Waypoint(position, rotation, pace * duration, command)
                for position, rotation, duration, command in legs
            ]
        ]

    def monitor(self, nsim: int) -> StackMonitor:
        return StackMonitor(self, BLOCKS[0], nsim)
