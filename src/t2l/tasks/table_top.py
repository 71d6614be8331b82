"""What tasks of arms with grippers at a table have in common."""

from abc import abstractmethod
from collections.abc import Sequence
from typing import Annotated, Any, ClassVar

import mujoco
import numpy as np
from mujoco.batch import Batch
from pydantic import Field

from t2l.robots import Robot, make_robot
from t2l.robots.specs import hold_at_rest
from t2l.sim.arrays import Array
from t2l.sim.batch import TIMESTEP_S
from t2l.tasks.task import Demonstrated, Task
from t2l.typed import Number, Switch, Typed

# what collides with what, by MuJoCo's bits: the table and what stands on it, not with each other;
# and what is moved, with everything
STANDS = {"contype": 1, "conaffinity": 2}
MOVES = {"contype": 3, "conaffinity": 3}

# of a coordinate on the table, [low, high], m
Range = Annotated[list[Annotated[Number, Field(ge=-1, le=1)]], Field(min_length=2, max_length=2)]


# where people see what happens from, m, and the camera's right and up
OVERVIEW = ((1.2, -0.75, 0.75), (0.71, 0.70, 0, -0.31, 0.31, 0.90))
# the same of what policies may see, which is nearer: of objects of 4 cm they are to see some pixels
GLOBAL = ((0.95, -0.32, 0.65), (0.56, 0.83, 0, -0.53, 0.36, 0.76))

Camera = tuple[tuple[float, ...], tuple[float, ...]]


class TableTopParameters(Typed):
    """Arguments of `TableTop`."""

    robot: str = Field("fr3_hand", description="name of a robot with a gripper on each arm")
    gravity_compensation: Switch = Field(description="true or false")
    start_spread_rad: Number = Field(
        ge=0, le=0.3, description="standard deviation of the arms' start, rad"
    )
    horizon_s: Number = Field(gt=0, le=120, description="how long a policy has, s")


class TableTop(Demonstrated):
    """Arms at a table, each with a gripper: one, unless a task says so.

    Args:
        robot: name of a robot of so many arms.
        gravity_compensation: whether the robot cancels the gravity of arms and hands; without it
            their weight loads the position controller.
        start_spread_rad: standard deviation of the arms' start about their home pose.
        horizon_s: how long a policy has.

    Raises:
        ConfigurationError: no such robot.
        ValueError: the robot has not so many arms, or one without a gripper.

    Attributes:
        arms: how many the task is for.
        camera: where people see what happens from.
        global_camera: where policies may.
    """

    arms: ClassVar[int] = 1
    camera: ClassVar[Camera] = OVERVIEW
    global_camera: ClassVar[Camera] = GLOBAL

    def __init__(
        self, robot: str, gravity_compensation: bool, start_spread_rad: float, horizon_s: float
    ):
        self.robot = make_robot(robot)
        self.gravity_compensation = gravity_compensation
        self.start_spread_rad = start_spread_rad
        self.horizon_s = horizon_s
        check_hands(self.robot, self.arms)
        own = _robot_names(self.robot)
        self.observation_names = (*own, *self.scene_names)
        self.robot_observation_size = len(own)

    @property
    @abstractmethod
    def scene_names(self) -> tuple[str, ...]:
        """Of the observation, what is not the robot's own."""

    def spec(self, visual: bool) -> mujoco.MjSpec:
        """The robot at its table; tasks add the rest."""
        return table_scene(
            self.robot, self.gravity_compensation, visual, self.camera, self.global_camera
        )

    def sample_starts(self, rng: np.random.Generator, n: int) -> np.ndarray:
        """The robot about its home, its grippers open; tasks put their objects."""
        return robot_starts(self, rng, n, self.start_spread_rad)

    def pose_of(self, name: str) -> slice:
        """Of a body that moves freely, where qpos has position and quaternion."""
        return pose_of(self.model, name)

    def grip(self, batch: Batch, arm: int = 0) -> np.ndarray:
        """(nsim, 3) position of an arm's tool, m."""
        return batch.bind("site_xpos")[:, self.tool_sites[arm]]

    def observe(self, batch: Batch) -> np.ndarray:
        """The robot's own state; tasks add the rest."""
        qpos, qvel = batch.bind("qpos"), batch.bind("qvel")
        position = batch.bind("site_xpos")[:, self.tool_sites]
        rows = batch.bind("site_xmat")[:, self.tool_sites].reshape(*position.shape[:2], 9)[:, :, :6]
        tools = np.concatenate([position, rows], axis=2).reshape(len(qpos), -1)
        joints = qpos[:, self.arm_qpos], qvel[:, self.arm_dofs], qpos[:, self.opening_qpos]
        return np.concatenate([*joints, tools], axis=1)


def table_scene(
    robot: Robot,
    gravity_compensation: bool,
    visual: bool,
    overview: Camera = OVERVIEW,
    near: Camera = GLOBAL,
) -> mujoco.MjSpec:
    """A robot at a table at the height of its base, with cameras and light if it is to be seen."""
    spec = robot.spec(gravity_compensation, visual)
    spec.option.timestep = TIMESTEP_S
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_DISCRETE
    spec.worldbody.add_geom(
        name="table",
        type=mujoco.mjtGeom.mjGEOM_PLANE,
        size=(1, 1, 0.05),
        rgba=(0.93, 0.92, 0.90, 1),
        **STANDS,
    )
    if visual:
        stage_lights(spec)
        for name, (position, axes) in {"overview": overview, "global": near}.items():
            spec.worldbody.add_camera(name=name, pos=position, xyaxes=axes, fovy=42)
    return spec


def start_at(robot: Robot, start_rad: Sequence[float]) -> np.ndarray:
    """(njoint,) rad where an arm starts: its home, unless another place is given.

    Raises:
        ValueError: not a number within its range for each joint.
    """
    start = np.array(start_rad, float) if len(start_rad) else robot.home
    low, high = robot.position_limit.T
    if start.shape != low.shape or np.any((start < low) | (start > high)):
        ranges = ", ".join(f"{a:.3g} to {b:.3g}" for a, b in robot.position_limit)
        raise ValueError(f"start_rad: found {list(start_rad)}; allowed: a number a joint: {ranges}")
    return start


def robot_starts(
    task: Task,
    rng: np.random.Generator,
    n: int,
    spread_rad: float,
    start: np.ndarray | None = None,
) -> np.ndarray:
    """(n, nq) starts with the robot about its home, its grippers open, and objects at their places.

    Args:
        spread_rad: standard deviation of the joints.
        start: (njoint,) rad, in place of home.
    """
    qpos = np.tile(task.model.qpos0, (n, 1))
    home = task.robot.home if start is None else start
    qpos[:, task.arm_qpos] = home + rng.normal(0, spread_rad, (n, home.size))
    opened = [gripper.opened_qpos for gripper in task.robot.grippers]
    qpos[:, task.gripper_qpos] = np.concatenate(opened)
    return qpos


def pose_of(model: mujoco.MjModel, name: str) -> slice:
    """Of a body that moves freely, where qpos has position and quaternion."""
    address = model.joint(name).qposadr[0]
    return slice(address, address + 7)


# how far the table goes in front of the robot where it ends, in x from 0 on and in y either way, m
TABLE_DEPTH, TABLE_HALF = 1.0, 0.5


def beyond_table(position: Array) -> Array:
    """Which of positions (n, 3 or more) m are beyond the table's edge, (n,) bool."""
    x, y = position[:, 0], position[:, 1]
    return (x < 0) | (x > TABLE_DEPTH) | (y < -TABLE_HALF) | (y > TABLE_HALF)


def add_cube(
    spec: mujoco.MjSpec, name: str, size_m: float, mass_kg: float, colour: Sequence[float]
) -> None:
    """A cube that lies on the table and moves freely."""
    half = size_m / 2
    body = spec.worldbody.add_body(name=name, pos=(0.5, 0, half))
    body.add_freejoint(name=name)
    add_box(body, name, (half, half, half), (0, 0, 0), colour, mass_kg)


def furniture_joints(name: str) -> tuple[str, str, str]:
    """The joints of `add_furniture`: x, y and yaw."""
    return f"{name}_x", f"{name}_y", f"{name}_yaw"


def add_furniture(
    spec: mujoco.MjSpec, name: str, mass_kg: float, push_n: float, push_nm: float
) -> mujoco.MjsBody:
    """A body that stands on the table wherever its joints say, and stays there.

    Args:
        push_n, push_nm: friction, which only a greater force or moment overcomes.
    """
    body = spec.worldbody.add_body(name=name, mass=mass_kg, inertia=(1, 1, 1))
    body.explicitinertial = True
    hinge, slide = mujoco.mjtJoint.mjJNT_HINGE, mujoco.mjtJoint.mjJNT_SLIDE
    axes = (slide, (1, 0, 0), push_n), (slide, (0, 1, 0), push_n), (hinge, (0, 0, 1), push_nm)
    for joint, (kind, axis, friction) in zip(furniture_joints(name), axes, strict=True):
        hold_at_rest(body.add_joint(name=joint, type=kind, axis=axis, frictionloss=friction))
    return body


def add_box(
    body: mujoco.MjsBody,
    name: str,
    size: Sequence[float],
    pos: Sequence[float],
    colour: Sequence[float],
    mass: float = 0.0,
    **more: Any,
) -> None:
    """A box that everything collides with, unless `more` says otherwise.

    Args:
        size: half of its edges, m.
        more: other fields of a MuJoCo geom.
    """
    box = mujoco.mjtGeom.mjGEOM_BOX
    more = {**MOVES, **more}
    body.add_geom(name=name, type=box, size=size, pos=pos, rgba=colour, mass=mass, **more)


def check_hands(robot: Robot, arms: int) -> None:
    """Raise ValueError where a robot has not so many arms, each with a gripper."""
    hands = len(robot.grippers)
    if len(robot.groups) != arms or hands != arms:
        raise ValueError(
            f"robot: found {robot.name}, a robot of {hands} arm{'s' * (hands != 1)} with a "
            f"gripper; allowed: of {arms}"
        )


def check_graspable(key: str, size_m: float, robot: Robot) -> None:
    """Raise ValueError where a gripper does not open a centimetre wider than a size."""
    widest = min(gripper.opening_m for gripper in robot.grippers) - 0.01
    if size_m > widest:
        raise ValueError(
            f"{key}: found {size_m:g}; allowed: up to {widest:g}, which the gripper of "
            f"{robot.name} can grasp"
        )


def check_range(key: str, low: float, high: float) -> None:
    """Raise ValueError where a range is empty."""
    if low >= high:
        raise ValueError(f"{key}: found [{low}, {high}]; allowed: low below high")


def _robot_names(robot: Robot) -> tuple[str, ...]:
    arms = [f"{group.name}/" for group in robot.groups] if len(robot.groups) > 1 else [""]
    tool = *"xyz", *(f"row{i}_{c}" for i in (1, 2) for c in "xyz")
    return (
        *(f"q.{joint}" for joint in robot.joints),
        *(f"dq.{joint}" for joint in robot.joints),
        *(f"{arm}finger" for arm in arms),
        *(f"{arm}grip.{name}" for arm in arms for name in tool),
    )


def stage_lights(spec: mujoco.MjSpec) -> None:
    """Light and sky of a scene that is to be seen."""
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
