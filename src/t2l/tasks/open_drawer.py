"""Open-Drawer: grasp a handle and pull a drawer open; by reinforcement learning.

Terms, weights, the drawer's spring and its damping are those of IsaacLab's manager-based cabinet
environment (Franka, joint positions), from which the study's task is derived (App. E). The cabinet
is one of boxes. The success rule is the study's.
"""

from functools import cached_property
from typing import NamedTuple

import mujoco
import numpy as np
from pydantic import Field

from t2l.sim.arrays import Array, columns, like, namespace
from t2l.tasks.learned_table_top import LearnedTableTop, LearnedTableTopParameters
from t2l.tasks.table_top import add_box
from t2l.tasks.terms import (
    Moment,
    ObservationTerm,
    RewardTerm,
    action_change,
    indicator,
    minus,
    norm,
    speed,
)
from t2l.typed import Number

DRAWER, HANDLE = "drawer", "handle"
TEMPLATE = "IsaacLab, manager-based cabinet environment"
# of the template: distances, m
AT_HANDLE, OFFSET, CLOSE = 0.2, 0.04, 0.03
# of the template: the drawer's spring and damping, N/m and N·s/m
STIFFNESS, DAMPING = 10.0, 1.0
# of the cabinet: half of the front's edges, half of the bar's thickness and length, how far the bar
# stands off, and how far the drawer opens, m
FRONT = (0.01, 0.2, 0.08)
BAR, BAR_LENGTH, STAND_OFF, TRAVEL = 0.008, 0.07, 0.05, 0.4
# from beside the robot, so that hand and handle are seen: position in m, the camera's right and up
OVERVIEW = ((0.0, -1.4, 1.0), (1.4, -0.5, 0, 0.25, 0.7, 2.21))
WOOD, STEEL = (0.72, 0.58, 0.42, 1), (0.35, 0.36, 0.38, 1)


class OpenDrawerParameters(LearnedTableTopParameters):
    """Of a drawer to open."""

    robot: str = Field(
        "fr3_hand", description="name of a robot of one arm with a gripper of sliding fingers"
    )
    start_spread_rad: Number = Field(
        0.06, ge=0, le=0.3, description="standard deviation of the arm's start about that, rad"
    )
    handle_x_m: Number = Field(0.65, ge=0.2, le=1, description="where the closed handle is, m")
    handle_z_m: Number = Field(0.5, ge=0.15, le=1, description="its height above the table, m")
    drawer_mass_kg: Number = Field(1.0, gt=0, le=20, description="mass of the drawer, kg")
    opened_m: Number = Field(
        0.2, gt=0, le=0.4, description="success is a drawer that is open further than it, m"
    )


class Measured(NamedTuple):
    """What terms need of a scene, (n, …) each.

    Attributes:
        open_m, speed_m_s: (n,) how far the drawer is open, and how fast it moves.
        to_handle: (n, 3) from the grip to the handle, m.
        forward, across: (n,) cosines between the hand's approach and the way into the cabinet, and
            between the hand's x and the bar.
        above, below: (n,) how far the fingertips are above the handle, and below it, m.
        closed_m: (n,) sum of how far the fingers are from open, m.
    """

    open_m: Array
    speed_m_s: Array
    to_handle: Array
    forward: Array
    across: Array
    above: Array
    below: Array
    closed_m: Array


def away(at: Moment) -> Array:
    """From the grip to the handle, (n,) m."""
    return norm(at.now.to_handle)


def approaching(at: Moment) -> Array:
    """1 / (1 + d²)², twice that near the handle."""
    distance = away(at)
    return (1 + indicator(distance <= AT_HANDLE)) / (1 + distance**2) ** 2


def aligned(at: Moment) -> Array:
    """How the hand is turned: (sign(a) a² + sign(b) b²) / 2 of its two cosines."""
    a, b, xp = at.now.forward, at.now.across, namespace(at.now.forward)
    return (xp.sign(a) * a**2 + xp.sign(b) * b**2) / 2


def around(at: Moment) -> Array:
    """Whether one finger is above the handle and the other one below, 0 or 1."""
    return indicator((at.now.above > 0) & (at.now.below > 0))


def fingers_near(at: Moment) -> Array:
    """How near the fingers are to the handle's height, where they are around it, m."""
    xp = namespace(at.now.above)
    return around(at) * (2 * OFFSET - xp.abs(at.now.above) - xp.abs(at.now.below))


def grasping(at: Moment) -> Array:
    """How far the fingers are closed, where the grip is at the handle, m."""
    return indicator(away(at) <= CLOSE) * at.now.closed_m


def opening(at: Moment) -> Array:
    """How far the drawer is open, twice that with the fingers around the handle, m."""
    return (around(at) + 1) * at.now.open_m


def stages(at: Moment) -> Array:
    """A half where it is open at all; 1 more each beyond 0.2 and 0.3 m, fingers around it."""
    far = indicator(at.now.open_m > 0.2) + indicator(at.now.open_m > 0.3)
    return 0.5 * indicator(at.now.open_m > 0.01) + far * around(at)


class OpenDrawer(LearnedTableTop):
    """Success: the drawer is open further than `opened_m` at the end of an episode.

    Raises:
        ConfigurationError: no such robot.
        ValueError: it has not one arm with a gripper of sliding fingers.
    """

    name = "open_drawer"
    instruction = "Pull the drawer open by its handle."
    parameters = OpenDrawerParameters
    hyperparameters = "drawer"
    camera = OVERVIEW
    goal_size = 0
    rewards = (
        RewardTerm("approach", 2.0, approaching, TEMPLATE),
        RewardTerm("align", 0.5, aligned, TEMPLATE),
        RewardTerm("fingers", 5.0, fingers_near, TEMPLATE),
        RewardTerm("around", 0.125, around, TEMPLATE),
        RewardTerm("grasp", 0.5, grasping, TEMPLATE),
        RewardTerm("open", 7.5, opening, TEMPLATE),
        RewardTerm("stages", 1.0, stages, TEMPLATE),
        RewardTerm("change", 1e-2, minus(action_change), TEMPLATE),
        RewardTerm("velocity", 1e-4, minus(speed), TEMPLATE),
    )

    def __init__(
        self,
        handle_x_m: float,
        handle_z_m: float,
        drawer_mass_kg: float,
        opened_m: float,
        **of_robot,
    ):
        super().__init__(**of_robot)
        self.handle = np.array([handle_x_m, 0.0, handle_z_m])
        self.drawer_mass_kg, self.opened_m = drawer_mass_kg, opened_m
        self.observations = (
            *self.own_state,
            ObservationTerm((DRAWER,), lambda at: at.now.open_m[:, None]),
            ObservationTerm((f"d{DRAWER}",), lambda at: at.now.speed_m_s[:, None]),
            ObservationTerm(
                tuple(f"{HANDLE}_from_grip.{c}" for c in "xyz"), lambda at: at.now.to_handle
            ),
        )
        fingers = [self.model.joint(joint) for joint in self.robot.grippers[0].joints]
        slides = [finger.type[0] == mujoco.mjtJoint.mjJNT_SLIDE for finger in fingers]
        if len(fingers) != 2 or not all(slides):
            raise ValueError(
                f"robot: found {self.robot.name}, whose gripper has no two sliding fingers;"
                " allowed: one that has, such as fr3_hand"
            )

    def spec(self, visual: bool) -> mujoco.MjSpec:
        """See `Task.spec`."""
        spec = super().spec(visual)
        x, _, z = self.handle + np.array([STAND_OFF, 0, 0])
        depth, (thick, wide, high) = 0.2, FRONT
        cabinet = spec.worldbody.add_body(name="cabinet", pos=(x + 2 * thick, 0, z))
        for side in (1, -1):
            add_box(
                cabinet, f"wall{side}", (depth, 0.01, high), (depth, side * (wide + 0.01), 0), WOOD
            )
            add_box(
                cabinet, f"board{side}", (depth, wide, 0.01), (depth, 0, side * (high + 0.01)), WOOD
            )
        drawer = spec.worldbody.add_body(
            name=DRAWER, pos=(x, 0, z), mass=self.drawer_mass_kg, inertia=(0.01, 0.01, 0.01),
            explicitinertial=True,
        )  # fmt: skip
        joint = drawer.add_joint(
            name=DRAWER, type=mujoco.mjtJoint.mjJNT_SLIDE, axis=(-1, 0, 0), range=(0, TRAVEL)
        )
        # polynomials, of which the first term is the constant
        joint.stiffness, joint.damping = (STIFFNESS, 0, 0), (DAMPING, 0, 0)
        add_box(drawer, "front", FRONT, (thick, 0, 0), WOOD)
        add_box(drawer, HANDLE, (BAR, BAR_LENGTH, BAR), (-STAND_OFF, 0, 0), STEEL)
        for side in (1, -1):
            post = (STAND_OFF / 2, BAR, BAR)
            add_box(
                drawer, f"post{side}", post, (-STAND_OFF / 2, side * (BAR_LENGTH - BAR), 0), STEEL
            )
        drawer.add_site(name=HANDLE, pos=(-STAND_OFF, 0, 0))
        return spec

    @cached_property
    def _ids(self) -> tuple[int, int, int, np.ndarray | slice]:
        """Of the drawer in qpos and qvel, of the handle's site, and of the fingers' bodies."""
        model, joint = self.model, self.model.joint(DRAWER)
        fingers = [model.joint(name).bodyid[0] for name in self.robot.grippers[0].joints]
        return joint.qposadr[0], joint.dofadr[0], model.site(HANDLE).id, columns(np.array(fingers))

    def sample_goals(self, rng, n):
        """See `Rewarded.sample_goals`: there is none."""
        return np.empty((n, 0))

    def measure(self, batch, goal):
        """See `Rewarded.measure`."""
        q, dof, handle, fingers = self._ids
        position, axes, bodies = (batch.bind(k) for k in ("site_xpos", "site_xmat", "xpos"))
        batch.forward(stage=mujoco.mjtStage.mjSTAGE_POS.value)
        tool, xp = self.tool_sites[0], namespace(position)
        grip, rotation = position[:, tool], xp.reshape(axes[:, tool], (-1, 3, 3))
        ahead = rotation[:, :, 2]
        # a fingertip is as far along the approach as the grip
        short = ((grip[:, None] - bodies[:, fingers]) * ahead[:, None]).sum(axis=2)
        height = bodies[:, fingers, 2] + short * ahead[:, None, 2] - position[:, handle, None, 2]
        opened = like(np.array(self.robot.grippers[0].opened_qpos), grip)
        return Measured(
            open_m=xp.asarray(batch.qpos[:, q], copy=True),
            speed_m_s=xp.asarray(batch.qvel[:, dof], copy=True),
            to_handle=position[:, handle] - grip,
            forward=xp.asarray(ahead[:, 0], copy=True),
            across=xp.asarray(rotation[:, 1, 0], copy=True),
            above=height[:, 0],
            below=-height[:, 1],
            closed_m=(opened - batch.qpos[:, columns(self.gripper_qpos)]).sum(axis=1),
        )

    def success(self, at):
        """See `Rewarded.success`."""
        return at.now.open_m > self.opened_m
