"""Block Stack: pick up the red block and leave it standing on the blue one."""

from typing import TYPE_CHECKING

import mujoco
import numpy as np
from mujoco.batch import Batch

from t2l.robots import make_robot
from t2l.sim.batch import TIMESTEP_S
from t2l.tasks.block_stack_parameters import BlockStackParameters
from t2l.tasks.stack_monitor import StackMonitor
from t2l.tasks.task import Demonstrated

if TYPE_CHECKING:
    from t2l.tasks.waypoints import Waypoint

BLOCKS = ("red_block", "blue_block")
_COLOURS = ((0.80, 0.20, 0.16, 1), (0.16, 0.36, 0.75, 1))


class BlockStack(Demonstrated):
    """A robot with one gripper at a table with two cubes.

    Args:
        robot: name of a robot with one gripper.
        gravity_compensation: whether the robot cancels the gravity of arm and hand; without it
            their weight loads the position controller.
        block_size_m: edge of both cubes.
        block_mass_kg: mass of each.
        placement_tolerance_m: largest horizontal distance between the blocks' centres that
            counts as stacked.
        workspace_x_m, workspace_y_m: where blocks start, (low, high).
        block_yaw_rad: blocks start turned by up to this much either way.
        start_spread_rad: standard deviation of the arm's start about its home pose.
        horizon_s: how long a policy has.

    Raises:
        ConfigurationError: no such robot.
        ValueError: the robot has not one gripper that opens wide enough; a workspace range is
            empty, or too small for the blocks to lie apart.
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
        self.robot = make_robot(robot)
        self.gravity_compensation = gravity_compensation
        self.block_size_m = block_size_m
        self.block_mass_kg = block_mass_kg
        self.placement_tolerance_m = placement_tolerance_m
        self.workspace_x_m = tuple(workspace_x_m)
        self.workspace_y_m = tuple(workspace_y_m)
        self.block_yaw_rad = block_yaw_rad
        self.start_spread_rad = start_spread_rad
        self.horizon_s = horizon_s
        if len(self.robot.groups) != 1 or len(self.robot.grippers) != 1:
            raise ValueError(f"robot: found {robot}; allowed: a robot of one arm with a gripper")
        widest = self.robot.grippers[0].opening_m - 0.01
        if block_size_m > widest:
            raise ValueError(
                f"block_size_m: found {block_size_m:g}; allowed: up to {widest:g}, which the "
                f"gripper of {robot} can grasp"
            )
        for key in ("workspace_x_m", "workspace_y_m"):
            low, high = getattr(self, key)
            if low >= high:
                raise ValueError(f"{key}: found [{low}, {high}]; allowed: low below high")
        width, depth = np.ptp([self.workspace_x_m, self.workspace_y_m], axis=1)
        if np.hypot(width, depth) < 1.5 * self.block_gap_m:
            raise ValueError(
                f"workspace_x_m, workspace_y_m: found {width:g} m by {depth:g} m; allowed: a "
                f"diagonal of at least {1.5 * self.block_gap_m:g} m, so that the blocks lie apart"
            )
        self.observation_names = _observation_names(self.robot.joints)
        self.robot_observation_size = self.observation_names.index(f"{BLOCKS[0]}.x")

    @property
    def block_gap_m(self) -> float:
        """Smallest distance of the blocks' centres at the start: the fingers fit in between."""
        return 2.5 * self.block_size_m

    def spec(self, visual: bool) -> mujoco.MjSpec:
        spec = self.robot.spec(self.gravity_compensation, visual)
        spec.option.timestep = TIMESTEP_S
        spec.option.integrator = mujoco.mjtIntegrator.mjINT_DISCRETE
        spec.worldbody.add_geom(
            name="table",
            type=mujoco.mjtGeom.mjGEOM_PLANE,
            size=(1, 1, 0.05),
            rgba=(0.93, 0.92, 0.90, 1),
            contype=1,
            conaffinity=2,
        )
        half = self.block_size_m / 2
        for name, colour in zip(BLOCKS, _COLOURS, strict=True):
            block = spec.worldbody.add_body(name=name, pos=(0.5, 0, half))
            block.add_freejoint(name=name)
            block.add_geom(
                name=name,
                type=mujoco.mjtGeom.mjGEOM_BOX,
                size=(half, half, half),
                mass=self.block_mass_kg,
                rgba=colour,
                contype=3,
                conaffinity=3,
            )
        if visual:
            _stage_lights(spec)
        return spec

    def sample_starts(self, rng: np.random.Generator, n: int) -> np.ndarray:
        qpos = np.tile(self.model.qpos0, (n, 1))
        home = self.robot.home
        qpos[:, self.arm_qpos] = home + rng.normal(0, self.start_spread_rad, (n, home.size))
        qpos[:, self.gripper_qpos] = self.robot.grippers[0].opened_qpos

        positions = np.empty((n, 2, 2))
        missing = np.ones(n, dtype=bool)
        while missing.any():
            low, high = np.transpose([self.workspace_x_m, self.workspace_y_m])
            positions[missing] = rng.uniform(low, high, (missing.sum(), 2, 2))
            gap = np.linalg.norm(positions[:, 0] - positions[:, 1], axis=1)
            missing = gap < self.block_gap_m
        yaws = rng.uniform(-self.block_yaw_rad, self.block_yaw_rad, (n, 2))
        for i, name in enumerate(BLOCKS):
            pose = qpos[:, self._pose(name)]
            pose[:, :2] = positions[:, i]
            pose[:, 2] = self.block_size_m / 2
            pose[:, 3] = np.cos(yaws[:, i] / 2)
            pose[:, 4:6] = 0
            pose[:, 6] = np.sin(yaws[:, i] / 2)
            qpos[:, self._pose(name)] = pose
        return qpos

    def block_poses(self, qpos: np.ndarray) -> np.ndarray:
        """(..., 2, 7) position and quaternion of the red and the blue block."""
        return np.stack([qpos[..., self._pose(name)] for name in BLOCKS], axis=-2)

    def observe(self, batch: Batch) -> np.ndarray:
        qpos, qvel = batch.bind("qpos"), batch.bind("qvel")
        site = self.tool_sites[0]
        grip = batch.bind("site_xpos")[:, site]
        poses = self.block_poses(qpos)
        red, blue = poses[:, 0, :3], poses[:, 1, :3]
        return np.concatenate(
            [
                qpos[:, self.arm_qpos],
                qvel[:, self.arm_dofs],
                qpos[:, self.opening_qpos],
                grip,
                batch.bind("site_xmat")[:, site].reshape(-1, 9)[:, :6],
                *(_position_and_axes(poses[:, i]) for i in range(2)),
                red - grip,
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

    def _pose(self, name: str) -> slice:
        address = self.model.joint(name).qposadr[0]
        return slice(address, address + 7)


def _position_and_axes(pose: np.ndarray) -> np.ndarray:
    """(n, 9): position and the first two columns of the rotation of (n, 7) poses."""
    w, x, y, z = pose[:, 3:].T
    first = np.stack([1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)], 1)
    second = np.stack([2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x)], 1)
    return np.concatenate([pose[:, :3], first, second], axis=1)


def _observation_names(joints: tuple[str, ...]) -> tuple[str, ...]:
    axes = [f"axis{i}_{c}" for i in (1, 2) for c in "xyz"]
    return (
        *(f"q.{joint}" for joint in joints),
        *(f"dq.{joint}" for joint in joints),
        "finger",
        *(f"grip.{c}" for c in "xyz"),
        *(f"grip.row{i}_{c}" for i in (1, 2) for c in "xyz"),
        *(f"{block}.{name}" for block in BLOCKS for name in (*"xyz", *axes)),
        *(f"{BLOCKS[0]}_from_grip.{c}" for c in "xyz"),
        *(f"{BLOCKS[1]}_from_{BLOCKS[0]}.{c}" for c in "xyz"),
    )


def _stage_lights(spec: mujoco.MjSpec) -> None:
    spec.visual.headlight.ambient = (0.45, 0.45, 0.45)
    spec.visual.headlight.diffuse = (0.5, 0.5, 0.5)
    spec.visual.headlight.specular = (0.1, 0.1, 0.1)
    spec.visual.global_.offwidth = 960
    spec.visual.global_.offheight = 720
    spec.add_texture(
        name="sky",
        type=mujoco.mjtTexture.mjTEXTURE_SKYBOX,
        builtin=mujoco.mjtBuiltin.mjBUILTIN_GRADIENT,
        rgb1=(1, 1, 1),
        rgb2=(0.86, 0.89, 0.92),
        width=64,
        height=64,
    )
    spec.worldbody.add_light(pos=(0.3, -0.6, 2.0), dir=(0.1, 0.3, -1.0), diffuse=(0.45, 0.45, 0.45))
    spec.worldbody.add_camera(
        name="overview", pos=(1.2, -0.75, 0.75), xyaxes=(0.71, 0.70, 0, -0.31, 0.31, 0.90), fovy=42
    )
