"""Mug Hanging: put the handle of a mug over a peg of a tree and let go."""

from functools import cached_property
from typing import TYPE_CHECKING

import mujoco
import numpy as np
from mujoco.batch import Batch

from t2l.tasks.hang_monitor import HangMonitor
from t2l.tasks.mug import HANDLE, HEIGHT, NAME, Mug
from t2l.tasks.mug_hanging_parameters import MugHangingParameters
from t2l.tasks.peg_tree import PegTree
from t2l.tasks.poses import position_and_axes, upright
from t2l.tasks.table_top import TableTop, check_graspable, check_range

if TYPE_CHECKING:
    from t2l.tasks.waypoints import Waypoint

# above the middle of the mug, where fingers hold it: below the rim, above the peg
GRASP_HEIGHT = 0.02
# along y from a mug at its start to the tip of the peg, so that a hand fits in between, m
ROOM_M = 0.12


class MugHanging(TableTop):
    """A robot with one gripper at a table with a mug and a tree of pegs.

    Fingers hold the mug across two of its sides. Let go, it swings about the peg.

    Args:
        robot, gravity_compensation, start_spread_rad, horizon_s: see `TableTop`.
        mug_diameter_m: what is left of the gripper's opening is how far the hand may miss it.
        handle_opening_m: edge of the square that the handle leaves open.
        peg_diameter_m: what is left of that opening is how far the handle may miss the peg.
        mug_x_m, mug_y_m: where the mug starts, (low, high).
        mug_yaw_rad: it starts turned by up to this much either way.

    Raises:
        ConfigurationError: no such robot.
        ValueError: the robot has not one arm with a gripper that opens wide enough; the peg does
            not fit the handle; a range is empty, or comes under the peg.
    """

    name = "mug_hanging"
    instruction = "Hang the mug on the red peg."
    parameters = MugHangingParameters
    # from where the opening of the handle and the tip of the peg are both seen
    camera = ((1.18, -0.68, 0.6), (0.68, 0.74, 0, -0.25, 0.23, 0.94))

    def __init__(
        self,
        robot: str,
        gravity_compensation: bool,
        mug_diameter_m: float,
        handle_opening_m: float,
        peg_diameter_m: float,
        mug_x_m: tuple[float, float],
        mug_y_m: tuple[float, float],
        mug_yaw_rad: float,
        start_spread_rad: float,
        horizon_s: float,
    ):
        super().__init__(robot, gravity_compensation, start_spread_rad, horizon_s)
        self.mug = Mug(mug_diameter_m, handle_opening_m)
        self.tree = PegTree(peg_diameter_m)
        self.mug_x_m, self.mug_y_m = tuple(mug_x_m), tuple(mug_y_m)
        self.mug_yaw_rad = mug_yaw_rad
        check_graspable("mug_diameter_m", mug_diameter_m, self.robot)
        if peg_diameter_m >= handle_opening_m:
            raise ValueError(
                f"peg_diameter_m: found {peg_diameter_m:g}; allowed: below the handle_opening_m "
                f"of {handle_opening_m:g}"
            )
        for key in ("mug_x_m", "mug_y_m"):
            check_range(key, *getattr(self, key))
        farthest = self.tree.peg[0, 1] - ROOM_M
        if self.mug_y_m[1] > farthest:
            raise ValueError(
                f"mug_y_m: found [{self.mug_y_m[0]:g}, {self.mug_y_m[1]:g}]; allowed: up to "
                f"{farthest:.3g}, clear of the tree"
            )

    @property
    def scene_names(self) -> tuple[str, ...]:
        axes = [f"axis{i}_{c}" for i in (1, 2) for c in "xyz"]
        return (
            *(f"{NAME}.{name}" for name in (*"xyz", *axes)),
            *(f"{HANDLE}_from_grip.{c}" for c in "xyz"),
            *(f"peg_from_{HANDLE}.{c}" for c in "xyz"),
        )

    def spec(self, visual: bool) -> mujoco.MjSpec:
        spec = super().spec(visual)
        self.tree.add_to(spec)
        self.mug.add_to(spec)
        return spec

    def sample_starts(self, rng: np.random.Generator, n: int) -> np.ndarray:
        qpos = super().sample_starts(rng, n)
        yaw = self.mug_yaw_rad
        low, high = np.transpose([self.mug_x_m, self.mug_y_m, (-yaw, yaw)])
        x, y, yaw = rng.uniform(low, high, (n, 3)).T
        standing = np.full(n, HEIGHT / 2)
        qpos[:, self.pose_of(NAME)] = upright(np.stack([x, y, standing], axis=1), yaw)
        return qpos

    def mug_pose(self, batch: Batch) -> np.ndarray:
        """(nsim, 7) position of the mug's middle, m, and quaternion."""
        return batch.bind("qpos")[:, self.pose_of(NAME)]

    def handle(self, batch: Batch) -> np.ndarray:
        """(nsim, 3) position of the middle of the handle's opening, m."""
        return batch.bind("site_xpos")[:, self._handle]

    def tip_from_handle(self, batch: Batch) -> np.ndarray:
        """(nsim, 3) from there to the tip of the peg, m."""
        return self.tree.peg[0] - self.handle(batch)

    def on_peg(self, batch: Batch) -> np.ndarray:
        """(nsim,) whether the middle line of the peg goes through the handle's opening."""
        axes = batch.bind("site_xmat")[:, self._handle].reshape(-1, 3, 3)
        # tip and root as the handle sees them: its opening is the square about zero at y = 0
        ends = (self.tree.peg - self.handle(batch)[:, None]) @ axes
        tip, root = ends[:, 0], ends[:, 1]
        crosses = tip[:, 1] * root[:, 1] < 0
        # where it does not cross, the share is not used
        share = tip[:, 1] / np.where(crosses, tip[:, 1] - root[:, 1], 1.0)
        through = tip + share[:, None] * (root - tip)
        return crosses & (np.abs(through[:, [0, 2]]) < self.mug.opening_m / 2).all(axis=1)

    def observe(self, batch: Batch) -> np.ndarray:
        return np.concatenate(
            [
                super().observe(batch),
                position_and_axes(self.mug_pose(batch)),
                self.handle(batch) - self.grip(batch),
                self.tip_from_handle(batch),
            ],
            axis=1,
        )

    def waypoints(self, rng: np.random.Generator, qpos: np.ndarray) -> "list[list[Waypoint]]":
        """Above the mug, down, grasp, lift, before the peg, onto it, down, let go, up, wait.

        Heights, pace, grasp and how far the mug goes onto the peg vary.
        """
        # only an expert needs them, and SciPy's rotations take long to import
        from scipy.spatial.transform import Rotation

        from t2l.tasks.waypoints import POINTING_DOWN, Waypoint

        pose, gripper = qpos[self.pose_of(NAME)], self.robot.grippers[0]
        opened, closed = gripper.opened, gripper.closed
        pace = rng.uniform(0.85, 1.2)
        turned = Rotation.from_quat(pose[3:], scalar_first=True)
        # of the hand in the mug's frame; across the fingers it is the mug that gives way
        held = np.array([rng.normal(0, 0.002), 0, GRASP_HEIGHT + rng.uniform(-0.003, 0.006)])
        grasp = pose[:3] + turned.apply(held)
        up = np.array([0, 0, 1])
        approach, lift, retreat = rng.uniform([0.10, 0.14, 0.09], [0.15, 0.20, 0.13])
        tip, root = self.tree.peg
        inwards = (root - tip) / np.linalg.norm(root - tip)
        # of the hand where the peg's tip is in the middle of the opening
        at_tip = tip - self.mug.handle + held
        before = at_tip - rng.uniform(0.05, 0.07) * inwards
        onto = at_tip + rng.uniform(0.055, 0.075) * inwards
        # until the handle all but rests on the peg
        play = (self.mug.opening_m - self.tree.peg_diameter_m) / 2
        hung = onto - 0.8 * play * up
        first, last = turned * POINTING_DOWN, POINTING_DOWN
        legs = [
            (grasp + approach * up, first, 1.0, opened),
            (grasp, first, 0.6, opened),
            (grasp, first, 0.25, closed),
            (grasp + lift * up, first, 0.6, closed),
            (before, last, 1.1, closed),
            (onto, last, 0.8, closed),
            (hung, last, 0.25, closed),
            (hung, last, 0.2, opened),
            (hung + retreat * up, last, 0.5, opened),
            (hung + retreat * up, last, 0.6, opened),
        ]
        return [
            [
                Waypoint(position, rotation, pace * duration, command)
                for position, rotation, duration, command in legs
            ]
        ]

    def monitor(self, nsim: int) -> HangMonitor:
        return HangMonitor(self, nsim)

    @cached_property
    def _handle(self) -> int:
        return self.model.site(HANDLE).id
