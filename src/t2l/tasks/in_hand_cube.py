"""In-Hand-Cube: turn a cube in the palm of a hand into an orientation; by learning.

Terms and weights are those of IsaacLab's manager-based in-hand environment (Allegro), tolerance and
ending those of its direct one. The study has the task in its table of existence (section V-B), and
states neither rewards nor goals nor what a success is.
"""

from functools import cached_property
from typing import NamedTuple

import mujoco
import numpy as np
from pydantic import Field

from t2l.robots import make_robot
from t2l.sim.arrays import Array, like, namespace
from t2l.sim.batch import TIMESTEP_S
from t2l.tasks.poses import (
    about,
    conjugate,
    into_frame,
    position_and_axes,
    product,
    rotation_rows,
)
from t2l.tasks.table_top import add_cube, pose_of, stage_lights
from t2l.tasks.task import Rewarded
from t2l.tasks.terms import (
    ObservationTerm,
    RewardTerm,
    TerminationTerm,
    action_change,
    indicator,
    minus,
    norm,
    speed,
    state_of,
)
from t2l.typed import Number, Typed

TEMPLATE = "IsaacLab, manager-based in-hand environment, Allegro"
CUBE = "cube"
# of the template: rad that keep the reward of an orientation finite, kg/m³ of the cube
EPSILON_RAD, DENSITY = 0.1, 400.0
# of IsaacLab's direct environment: m from its place at which a cube is dropped
DROPPED_M = 0.24
# how far above the palm the cube begins to fall, m
ABOVE_M = 0.003


class InHandCubeParameters(Typed):
    """Arguments of `InHandCube`."""

    robot: str = Field("allegro_hand", description="name of a robot that is a hand")
    cube_size_m: Number = Field(0.06, ge=0.02, le=0.1, description="edge of the cube, m")
    yaw_rad: Number = Field(
        1.571, ge=0, le=3.15, description="goals are turned about the palm's normal up to it, rad"
    )
    tilt_rad: Number = Field(
        0.0, ge=0, le=3.15,
        description="and before about two axes in the palm, up to it, rad; IsaacLab's goals have "
        "3.15 here and no yaw",
    )  # fmt: skip
    start_spread_rad: Number = Field(
        0.05, ge=0, le=0.3, description="joints start uniformly up to it from home, rad"
    )
    start_spread_m: Number = Field(
        0.005, ge=0, le=0.02, description="the cube starts up to it from its place, each way, m"
    )
    tolerance_rad: Number = Field(
        0.2, gt=0, le=3.15, description="success is an angle from the goal below it, rad"
    )


class Measured(NamedTuple):
    """What terms need of a cube in a hand, (n, …) each, in the frame of the palm.

    Attributes:
        cube: (n, 7) pose, position in m above a quaternion.
        linear, angular: (n, 3) m/s and rad/s; the second in the cube's own frame.
        away: (n, 4) the quaternion from the cube's orientation to the goal's, w not below 0.
        away_rad: (n,) its angle.
        dropped: (n,) bool.
    """

    cube: Array
    linear: Array
    angular: Array
    away: Array
    away_rad: Array
    dropped: Array


class InHandCube(Rewarded):
    """Success: the cube within `tolerance_rad` of its goal at the end of an episode, and not lost.

    A goal is an orientation in the frame of the palm, (n, 4) quaternions. A cube that has left the
    palm ends the episode as a failure.

    Raises:
        ConfigurationError: no such robot.
        ValueError: it is no hand.
    """

    name = "in_hand_cube"
    instruction = "Turn the cube in the palm into its orientation."
    parameters = InHandCubeParameters
    hyperparameters = "hand"
    steady = False
    least_rate_hz = 120.0
    on_gpu = True
    goal_size = 4
    rewards = (
        RewardTerm("orientation", 1.0, lambda at: 1 / (at.now.away_rad + EPSILON_RAD), TEMPLATE),
        RewardTerm("success", 250.0, lambda at: indicator(at.task.success(at)), TEMPLATE),
        RewardTerm("velocity", 2.5e-5, minus(speed), TEMPLATE),
        RewardTerm("action", 1e-4, minus(lambda at: (at.action**2).sum(axis=1)), TEMPLATE),
        RewardTerm("change", 1e-2, minus(action_change), TEMPLATE),
    )
    terminations = (TerminationTerm("dropped", lambda at: at.now.dropped),)

    def __init__(
        self,
        robot: str,
        cube_size_m: float,
        yaw_rad: float,
        tilt_rad: float,
        start_spread_rad: float,
        start_spread_m: float,
        tolerance_rad: float,
    ):
        self.robot = make_robot(robot)
        if self.robot.palm is None:
            raise ValueError(f"robot: found {robot}, which is no hand; allowed: one that is")
        self.cube_size_m, self.tolerance_rad = cube_size_m, tolerance_rad
        self.yaw_rad, self.tilt_rad = yaw_rad, tilt_rad
        self.start_spread_rad, self.start_spread_m = start_spread_rad, start_spread_m
        own = state_of(self.robot.joints)
        self.robot_observation_size = sum(len(term.names) for term in own)
        pose = (*"xyz", *(f"axis{i}_{c}" for i in (1, 2) for c in "xyz"))

        def named(prefix: str, names: str | tuple[str, ...]) -> tuple[str, ...]:
            return tuple(f"{prefix}.{name}" for name in names)

        self.observations = (
            *own,
            ObservationTerm(named(CUBE, pose), lambda at: position_and_axes(at.now.cube)),
            ObservationTerm(named("velocity", "xyz"), lambda at: at.now.linear),
            ObservationTerm(named("turn", "xyz"), lambda at: at.now.angular),
            ObservationTerm(named("goal", "wxyz"), lambda at: at.goal),
            ObservationTerm(named("away", "wxyz"), lambda at: at.now.away),
        )

    def spec(self, visual: bool) -> mujoco.MjSpec:
        """The hand and the cube, with nothing below."""
        spec = self.robot.spec(gravity_compensation=True, visual=visual)
        spec.option.timestep = TIMESTEP_S
        spec.option.integrator = mujoco.mjtIntegrator.mjINT_DISCRETE
        mass = DENSITY * self.cube_size_m**3
        add_cube(spec, CUBE, self.cube_size_m, mass, (0.85, 0.55, 0.2, 1))
        if visual:
            stage_lights(spec)
            spec.worldbody.add_camera(
                name="overview", pos=(0.36, -0.33, 0.44),
                xyaxes=(0.72, 0.69, 0, -0.39, 0.41, 0.82),
                fovy=34,
            )  # fmt: skip
        return spec

    def sample_starts(self, rng, n):
        """See `Task.sample_starts`: the cube just above the palm, as the palm is turned."""
        qpos = np.tile(self.model.qpos0, (n, 1))
        spread = self.start_spread_rad
        joints = self.robot.home + rng.uniform(-spread, spread, (n, len(self.robot.joints)))
        qpos[:, self.arm_qpos] = np.clip(joints, *self.robot.position_limit.T)
        place = np.full((n, 3), self.cube_size_m / 2 + ABOVE_M)
        place[:, :2] = rng.uniform(-self.start_spread_m, self.start_spread_m, (n, 2))
        position, turn = self.palm_pose
        rotation = np.concatenate(rotation_rows(turn[None]))
        qpos[:, self.cube_qpos] = np.column_stack(
            [position + place @ rotation.T, np.tile(turn, (n, 1))]
        )
        return qpos

    def sample_goals(self, rng, n):
        """See `Rewarded.sample_goals`: quaternions in the frame of the palm."""
        spans = self.tilt_rad, self.tilt_rad, self.yaw_rad
        first, second, last = (
            about(axis, rng.uniform(-span, span, n)) for axis, span in enumerate(spans)
        )
        return product(last, product(first, second))

    def measure(self, batch, goal):
        """See `Rewarded.measure`."""
        qpos, twist = batch.qpos[:, self.cube_qpos], batch.qvel[:, self.cube_dofs]
        xp = namespace(qpos)
        position, turn = (like(values, qpos)[None] for values in self.palm_pose)
        rows = rotation_rows(turn)
        place = into_frame(rows, qpos[:, :3] - position)
        orientation = product(conjugate(turn), qpos[:, 3:])
        away = product(goal, conjugate(orientation))
        away = xp.where(away[:, :1] < 0, -away, away)
        sine = norm(away[:, 1:])
        height = self.cube_size_m / 2
        rest = like(np.array([[0.0, 0.0, height]]), qpos)
        return Measured(
            cube=xp.concat([place, orientation], axis=1),
            linear=into_frame(rows, twist[:, :3]),
            angular=xp.asarray(twist[:, 3:], copy=True),
            away=away,
            away_rad=2 * xp.atan2(sine, away[:, 0]),
            dropped=norm(place - rest) > DROPPED_M,
        )

    def success(self, at):
        """See `Rewarded.success`."""
        return at.now.away_rad < self.tolerance_rad

    @cached_property
    def palm_pose(self) -> tuple[np.ndarray, np.ndarray]:
        """Where things rest, (3,) m, and how the palm is turned, (4,) quaternion."""
        data = mujoco.MjData(self.model)
        mujoco.mj_kinematics(self.model, data)
        site, turn = data.site(self.robot.palm), np.empty(4)
        mujoco.mju_mat2Quat(turn, site.xmat)
        return site.xpos.copy(), turn

    @cached_property
    def cube_qpos(self) -> slice:
        """Where qpos has the cube's position and quaternion."""
        return pose_of(self.model, CUBE)

    @cached_property
    def cube_dofs(self) -> slice:
        """Where qvel has the cube's velocity and turning."""
        address = int(self.model.joint(CUBE).dofadr[0])
        return slice(address, address + 6)
