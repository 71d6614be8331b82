"""What tasks of an arm with a gripper at a table have in common that are learned by trying.

`LearnedTableTop` is the arm, `LearnedCube` the arm with a cube that lies somewhere on the table.
"""

from collections.abc import Sequence
from functools import cached_property
from typing import ClassVar

import mujoco
import numpy as np
from mujoco.batch import Batch
from pydantic import Field

from t2l.robots import make_robot
from t2l.sim.arrays import Array, columns
from t2l.tasks.poses import upright
from t2l.tasks.table_top import (
    OVERVIEW,
    Camera,
    Range,
    add_cube,
    beyond_table,
    check_hands,
    check_range,
    pose_of,
    robot_starts,
    start_at,
    table_scene,
)
from t2l.tasks.task import Rewarded
from t2l.tasks.terms import ObservationTerm, TerminationTerm, state_of
from t2l.typed import Number, Switch, Typed

CUBE = "cube"


class LearnedTableTopParameters(Typed):
    """Arguments of `LearnedTableTop`."""

    robot: str = Field("fr3_hand", description="name of a robot of one arm with a gripper")
    gravity_compensation: Switch = Field(
        True, description="whether the robot cancels the gravity of its arm, as in IsaacLab"
    )
    start_rad: list[Number] = Field(
        [], description="where the arm starts, rad a joint; without this key at the robot's home"
    )
    start_spread_rad: Number = Field(
        0.0, ge=0, le=0.3, description="standard deviation of the arm's start about that, rad"
    )


class LearnedTableTop(Rewarded):
    """An arm with a gripper at a table.

    Raises:
        ConfigurationError: no such robot.
        ValueError: it has not one arm with a gripper, or does not start within its ranges.

    Attributes:
        camera: where people see what happens from.
    """

    steady = False
    # at 100 Hz the force-limited fingers swing about what they are to press
    least_rate_hz = 200.0
    on_gpu = True
    camera: ClassVar[Camera] = OVERVIEW

    def __init__(
        self,
        robot: str,
        gravity_compensation: bool,
        start_rad: Sequence[float],
        start_spread_rad: float,
    ):
        self.robot, self.gravity_compensation = make_robot(robot), gravity_compensation
        check_hands(self.robot, 1)
        self.start, self.start_spread_rad = start_at(self.robot, start_rad), start_spread_rad

    @property
    def own_state(self) -> tuple[ObservationTerm, ...]:
        """What a policy sees of the robot: its joints, and how far the gripper is open."""
        joints = state_of(self.robot.joints)
        if self.closed_hand:
            return joints
        return (*joints, ObservationTerm(("finger",), lambda at: at.batch.qpos[:, self._opening]))

    @property
    def robot_observation_size(self) -> int:
        """See `Task`."""
        return sum(len(term.names) for term in self.own_state)

    def spec(self, visual: bool) -> mujoco.MjSpec:
        """The robot at its table; tasks add the rest."""
        return table_scene(self.robot, self.gravity_compensation, visual, self.camera)

    def sample_starts(self, rng, n):
        """The arm about its start, its gripper open; tasks put their objects."""
        return robot_starts(self, rng, n, self.start_spread_rad, self.start)

    def grip(self, batch: Batch) -> Array:
        """(n, 3) m, the point between the fingertips; a view of what `batch.forward` derives."""
        return batch.bind("site_xpos")[:, self.tool_sites[0]]

    @cached_property
    def _opening(self) -> np.ndarray | slice:
        return columns(self.opening_qpos)


class LearnedCubeParameters(LearnedTableTopParameters):
    """Arguments of `LearnedCube`."""

    cube_size_m: Number = Field(0.048, ge=0.01, le=0.2, description="edge of the cube, m")
    cube_mass_kg: Number = Field(0.1, gt=0, le=2, description="mass of the cube, kg")
    workspace_x_m: Range = Field([0.4, 0.6], description="where the cube starts, [low, high], m")
    workspace_y_m: Range = Field([-0.25, 0.25], description="where the cube starts, [low, high], m")
    cube_yaw_rad: Number = Field(
        0.0, ge=0, le=3.15, description="the cube starts turned up to it either way, rad"
    )


class LearnedCube(LearnedTableTop):
    """A cube on the table; `now.cube` (n, 3 or more) begins with its centre, m.

    Raises:
        ValueError: as `LearnedTableTop`; or a range is empty.
    """

    colour: ClassVar[tuple[float, ...]]
    # IsaacLab's waits until it has fallen
    terminations = (TerminationTerm("off_table", lambda at: beyond_table(at.now.cube)),)

    def __init__(
        self,
        cube_size_m: float,
        cube_mass_kg: float,
        workspace_x_m: tuple[float, float],
        workspace_y_m: tuple[float, float],
        cube_yaw_rad: float,
        **of_robot,
    ):
        super().__init__(**of_robot)
        check_range("workspace_x_m", *workspace_x_m)
        check_range("workspace_y_m", *workspace_y_m)
        self.cube_size_m, self.cube_mass_kg = cube_size_m, cube_mass_kg
        self.workspace = np.array([workspace_x_m, workspace_y_m])
        self.cube_yaw_rad = cube_yaw_rad

    def spec(self, visual: bool) -> mujoco.MjSpec:
        """See `Task.spec`."""
        spec = super().spec(visual)
        add_cube(spec, CUBE, self.cube_size_m, self.cube_mass_kg, self.colour)
        return spec

    def sample_places(self, rng: np.random.Generator, n: int) -> tuple[np.ndarray, np.ndarray]:
        """Centres (n, 3) m of cubes that lie on the table, and their turns (n,) rad."""
        place = rng.uniform(*self.workspace.T, (n, 2))
        yaw = rng.uniform(-self.cube_yaw_rad, self.cube_yaw_rad, n)
        height = np.full((n, 1), self.cube_size_m / 2)
        return np.concatenate([place, height], axis=1), yaw

    def sample_starts(self, rng, n):
        """See `Task.sample_starts`."""
        qpos = super().sample_starts(rng, n)
        qpos[:, self.cube_qpos] = upright(*self.sample_places(rng, n))
        return qpos

    @cached_property
    def cube_qpos(self) -> slice:
        """Where qpos has the cube's position and quaternion."""
        return pose_of(self.model, CUBE)
