"""Bimanual handover: one hand picks up a bar and gives it to the other."""

from functools import cached_property
from typing import TYPE_CHECKING

import mujoco
import numpy as np
from mujoco.batch import Batch

from t2l.tasks.bimanual_handover_parameters import BimanualHandoverParameters
from t2l.tasks.handover_monitor import HandoverMonitor
from t2l.tasks.poses import upright
from t2l.tasks.table_top import TableTop, check_graspable, check_range

if TYPE_CHECKING:
    from t2l.tasks.waypoints import Waypoint

BAR = "bar"
# the arms, by their place in the robot's groups
GIVER, TAKER = 0, 1
# of each hand from its end of the bar: the width of a finger and what grasps vary by, m
FROM_END = 0.035
# where the bar's middle is handed over, between the arms and well above the table, m
MEETING = (0.0, 0.0, 0.30)
# of the taking hand, so that there is room for both wrists, rad
TILT = 0.15


class BimanualHandover(TableTop):
    """A robot of two arms that face each other along x across a table with a bar.

    The first arm has the bar on its side; the second can reach where `MEETING` is.

    Args:
        robot, gravity_compensation, start_spread_rad, horizon_s: see `TableTop`.
        bar_length_m, bar_width_m, bar_height_m: of the bar, as it lies; what the width leaves of
            the gripper's opening is how far a hand may miss it sideways.
        bar_mass_kg: its mass.
        bar_x_m, bar_y_m: where its middle lies at the start, (low, high).
        bar_yaw_rad: it starts turned from x by up to this much either way.

    Raises:
        ConfigurationError: no such robot.
        ValueError: the robot has not two arms with grippers that open wide enough; a range is
            empty.
    """

    name = "bimanual_handover"
    instruction = "Pick up the bar and hand it over to the other hand."
    parameters = BimanualHandoverParameters
    arms = 2
    # from the side, where both hands are seen
    camera = ((0.0, -1.5, 0.85), (1, 0, 0, 0, 0.34, 0.94))

    def __init__(
        self,
        robot: str,
        gravity_compensation: bool,
        bar_length_m: float,
        bar_width_m: float,
        bar_height_m: float,
        bar_mass_kg: float,
        bar_x_m: tuple[float, float],
        bar_y_m: tuple[float, float],
        bar_yaw_rad: float,
        start_spread_rad: float,
        horizon_s: float,
    ):
        super().__init__(robot, gravity_compensation, start_spread_rad, horizon_s)
        self.bar_size_m = np.array([bar_length_m, bar_width_m, bar_height_m])
        self.bar_mass_kg = bar_mass_kg
        self.bar_x_m, self.bar_y_m = tuple(bar_x_m), tuple(bar_y_m)
        self.bar_yaw_rad = bar_yaw_rad
        check_graspable("bar_width_m", bar_width_m, self.robot)
        for key in ("bar_x_m", "bar_y_m"):
            check_range(key, *getattr(self, key))

    @property
    def scene_names(self) -> tuple[str, ...]:
        return (
            *(f"bar.{c}" for c in "xyz"),
            *(f"bar.axis{i}_{c}" for i in (1, 2) for c in "xyz"),
            *(f"bar_from_{group.name}/grip.{c}" for group in self.robot.groups for c in "xyz"),
        )

    def spec(self, visual: bool) -> mujoco.MjSpec:
        spec = super().spec(visual)
        # or a bar that is held at one end slowly turns in the fingers
        spec.option.cone, spec.option.impratio = mujoco.mjtCone.mjCONE_ELLIPTIC, 10
        bar = spec.worldbody.add_body(name=BAR, pos=(0, 0, self.bar_size_m[2] / 2))
        bar.add_freejoint(name=BAR)
        bar.add_geom(
            name=BAR,
            type=mujoco.mjtGeom.mjGEOM_BOX,
            size=self.bar_size_m / 2,
            mass=self.bar_mass_kg,
            rgba=(0.85, 0.55, 0.15, 1),
            contype=3,
            conaffinity=3,
        )
        return spec

    def sample_starts(self, rng: np.random.Generator, n: int) -> np.ndarray:
        qpos = super().sample_starts(rng, n)
        yaw = self.bar_yaw_rad
        low, high = np.transpose([self.bar_x_m, self.bar_y_m, (-yaw, yaw)])
        x, y, yaw = rng.uniform(low, high, (n, 3)).T
        middle = np.stack([x, y, np.full(n, self.bar_size_m[2] / 2)], axis=1)
        qpos[:, self.bar_qpos] = upright(middle, yaw)
        return qpos

    @cached_property
    def bar_qpos(self) -> slice:
        """Of the bar's position and quaternion in qpos."""
        return self.pose_of(BAR)

    def bar(self, batch: Batch) -> np.ndarray:
        """(nsim, 3) position of the bar's middle, m."""
        return batch.bind("xpos")[:, self._bar]

    def bar_axes(self, batch: Batch) -> np.ndarray:
        """(nsim, 3, 3) the bar's rotation; its first column is along the bar."""
        return batch.bind("xmat")[:, self._bar].reshape(-1, 3, 3)

    def height(self, batch: Batch) -> np.ndarray:
        """(nsim,) m, of the bar's lowest corner above the table."""
        return self.bar(batch)[:, 2] - np.abs(self.bar_axes(batch)[:, 2]) @ self.bar_size_m / 2

    def distance_from_bar(self, batch: Batch, arm: int) -> np.ndarray:
        """(nsim,) m, from an arm's tool to the bar's middle line."""
        offset = self.grip(batch, arm) - self.bar(batch)
        axis = self.bar_axes(batch)[:, :, 0]
        half = self.bar_size_m[0] / 2
        along = np.clip((offset * axis).sum(axis=1), -half, half)
        return np.linalg.norm(offset - along[:, None] * axis, axis=1)

    def observe(self, batch: Batch) -> np.ndarray:
        bar, axes = self.bar(batch), self.bar_axes(batch)
        return np.concatenate(
            [
                super().observe(batch),
                bar,
                axes[:, :, 0],
                axes[:, :, 1],
                *(bar - self.grip(batch, arm) for arm in (GIVER, TAKER)),
            ],
            axis=1,
        )

    def waypoints(self, rng: np.random.Generator, qpos: np.ndarray) -> "list[list[Waypoint]]":
        """One hand lifts the bar to the meeting, the other takes it; place, pace and grasp vary."""
        # only an expert needs them, and SciPy's rotations take long to import
        from scipy.spatial.transform import Rotation

        from t2l.tasks.waypoints import POINTING_DOWN, in_step

        giver, taker = self.robot.grippers
        pose, reach = qpos[self.bar_qpos], self.bar_size_m[0] / 2 - FROM_END
        position, turned = pose[:3], Rotation.from_quat(pose[3:], scalar_first=True)
        pace = rng.uniform(0.85, 1.2)
        # where each hand is on the bar: along it, across it and up
        given, taken = rng.normal([[-reach, 0, 0], [reach, 0, 0]], [0.006, 0.003, 0])
        # deeper, the palm meets the bar
        given[2], taken[2] = rng.uniform(-0.006, 0.02, 2)
        above, lift = rng.uniform([0.08, 0.08], [0.12, 0.14])[:, None] * np.array([0, 0, 1])
        grasp, down = position + turned.apply(given), turned * POINTING_DOWN
        # the giver points straight down there, so the bar lies along x
        meeting = rng.normal(MEETING, [0.01, 0.015, 0.01])
        give, take = meeting + given, meeting + taken
        away = give + rng.uniform([-0.12, 0, 0.10], [-0.08, 0, 0.14])
        slanted = Rotation.from_euler("ZY", [np.pi, -rng.normal(TILT, 0.03)]) * POINTING_DOWN
        # about there: a policy is to see how the taker comes to the bar from either side
        wait = rng.normal(take - slanted.apply([0, 0, rng.uniform(0.10, 0.14)]), [0.015, 0.03, 0])
        phases = [
            # s, and where the giver and the taker are at its end
            (1.0, (grasp + above, down, giver.opened), (wait, slanted, taker.opened)),
            (0.8, (grasp, down, giver.opened), None),
            (0.2, None, None),
            (0.3, (grasp, down, giver.closed), None),
            (0.5, (grasp + lift, down, giver.closed), None),
            (1.1, (give, POINTING_DOWN, giver.closed), None),
            (1.0, None, (take, slanted, taker.opened)),
            (0.2, None, None),
            (0.3, None, (take, slanted, taker.closed)),
            (0.25, (give, POINTING_DOWN, giver.opened), None),
            (0.6, (away, POINTING_DOWN, giver.opened), None),
            (0.6, None, None),
        ]
        return in_step([(pace * duration, goals) for duration, *goals in phases])

    def monitor(self, nsim: int) -> HandoverMonitor:
        return HandoverMonitor(self, nsim)

    @cached_property
    def _bar(self) -> int:
        return self.model.body(BAR).id
