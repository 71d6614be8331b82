"""What tasks of one arm with a gripper at a table have in common."""

from abc import abstractmethod
from typing import Annotated

import mujoco
import numpy as np
from mujoco.batch import Batch
from pydantic import Field

from t2l.robots import Robot, make_robot
from t2l.sim.batch import TIMESTEP_S
from t2l.tasks.task import Demonstrated
from t2l.typed import Number, Typed

# of a coordinate on the table, [low, high], m
Range = Annotated[list[Annotated[Number, Field(ge=-1, le=1)]], Field(min_length=2, max_length=2)]


class TableTopParameters(Typed):
    """Arguments of `TableTop`."""

    robot: str = Field("fr3_hand", description="name of a robot with a gripper")
    gravity_compensation: bool = Field(description="true or false")
    start_spread_rad: Number = Field(
        ge=0, le=0.3, description="standard deviation of the arm's start, rad"
    )
    horizon_s: Number = Field(gt=0, le=120, description="how long a policy has, s")


class TableTop(Demonstrated):
    """An arm with a gripper at a table.

    Args:
        robot: name of a robot with one gripper.
        gravity_compensation: whether the robot cancels the gravity of arm and hand; without it
            their weight loads the position controller.
        start_spread_rad: standard deviation of the arm's start about its home pose.
        horizon_s: how long a policy has.

    Raises:
        ConfigurationError: no such robot.
        ValueError: the robot has not one arm with a gripper.

    Attributes:
        camera: where people see what happens from, m, and the camera's right and up.
        global_camera: the same of what policies may see, which is nearer: of objects of 4 cm they
            are to see a few pixels.
    """

    camera = ((1.2, -0.75, 0.75), (0.71, 0.70, 0, -0.31, 0.31, 0.90))
    global_camera = ((0.95, -0.32, 0.65), (0.56, 0.83, 0, -0.53, 0.36, 0.76))

    def __init__(
        self, robot: str, gravity_compensation: bool, start_spread_rad: float, horizon_s: float
    ):
        self.robot = make_robot(robot)
        self.gravity_compensation = gravity_compensation
        self.start_spread_rad = start_spread_rad
        self.horizon_s = horizon_s
        if len(self.robot.groups) != 1 or len(self.robot.grippers) != 1:
            raise ValueError(f"robot: found {robot}; allowed: a robot of one arm with a gripper")
        own = _robot_names(self.robot.joints)
        self.observation_names = (*own, *self.scene_names)
        self.robot_observation_size = len(own)

    @property
    @abstractmethod
    def scene_names(self) -> tuple[str, ...]:
        """Of the observation, what is not the robot's own."""

    def spec(self, visual: bool) -> mujoco.MjSpec:
        """The robot at its table; tasks add the rest."""
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
        if visual:
            _stage_lights(spec)
            cameras = {"overview": self.camera, "global": self.global_camera}
            for name, (position, axes) in cameras.items():
                spec.worldbody.add_camera(name=name, pos=position, xyaxes=axes, fovy=42)
        return spec

    def sample_starts(self, rng: np.random.Generator, n: int) -> np.ndarray:
        """The robot about its home, its gripper open; tasks put their objects."""
        qpos = np.tile(self.model.qpos0, (n, 1))
        home = self.robot.home
        qpos[:, self.arm_qpos] = home + rng.normal(0, self.start_spread_rad, (n, home.size))
        qpos[:, self.gripper_qpos] = self.robot.grippers[0].opened_qpos
        return qpos

    def grip(self, batch: Batch) -> np.ndarray:
        """(nsim, 3) position of the tool, m."""
        return batch.bind("site_xpos")[:, self.tool_sites[0]]

    def observe(self, batch: Batch) -> np.ndarray:
        """The robot's own state; tasks add the rest."""
        qpos, qvel = batch.bind("qpos"), batch.bind("qvel")
        return np.concatenate(
            [
                qpos[:, self.arm_qpos],
                qvel[:, self.arm_dofs],
                qpos[:, self.opening_qpos],
                self.grip(batch),
                batch.bind("site_xmat")[:, self.tool_sites[0]].reshape(-1, 9)[:, :6],
            ],
            axis=1,
        )


def check_graspable(key: str, size_m: float, robot: Robot) -> None:
    """Raise ValueError where the gripper does not open a centimetre wider than a size."""
    widest = robot.grippers[0].opening_m - 0.01
    if size_m > widest:
        raise ValueError(
            f"{key}: found {size_m:g}; allowed: up to {widest:g}, which the gripper of "
            f"{robot.name} can grasp"
        )


def check_range(key: str, low: float, high: float) -> None:
    """Raise ValueError where a range is empty."""
    if low >= high:
        raise ValueError(f"{key}: found [{low}, {high}]; allowed: low below high")


def _robot_names(joints: tuple[str, ...]) -> tuple[str, ...]:
    return (
        *(f"q.{joint}" for joint in joints),
        *(f"dq.{joint}" for joint in joints),
        "finger",
        *(f"grip.{c}" for c in "xyz"),
        *(f"grip.row{i}_{c}" for i in (1, 2) for c in "xyz"),
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
