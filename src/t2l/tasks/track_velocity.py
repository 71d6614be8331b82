"""Track-Velocity: walk on flat ground with the velocity that is asked for; by learning.

Terms, weights, goals and the ending are those of IsaacLab's manager-based velocity environment
(G1, flat), from which the study's task is derived (App. E). The success rule is the study's.
"""

import math
from collections.abc import Callable
from functools import cached_property
from typing import Annotated, NamedTuple

import mujoco
import numpy as np
from pydantic import Field

from t2l.robots import make_robot
from t2l.sim.arrays import Array, columns, like, namespace
from t2l.tasks.flat_ground import felt, ground_scene
from t2l.tasks.poses import into_frame, rotation_rows
from t2l.tasks.table_top import check_range
from t2l.tasks.task import Rewarded
from t2l.tasks.terms import (
    Moment,
    ObservationTerm,
    RewardTerm,
    TerminationTerm,
    action_change,
    indicator,
    minus,
    norm,
    state_of,
)
from t2l.typed import Number, Typed

TEMPLATE = "IsaacLab, manager-based velocity environment, G1 flat"
# of the template: m/s and rad/s over which tracking pays, s of a step that pays, m/s below which a
# command asks for no step, N that are a contact, share of a range beyond which an ankle costs
OVER, STEP_S, SLOW, CONTACT_N, SOFT = 0.5, 0.4, 0.1, 1.0, 0.9
# of the template: turn rate commanded for an error of heading, 1/s, and the fastest, rad/s
TURNING, FASTEST = 0.5, 1.0

Span = Annotated[list[Annotated[Number, Field(ge=-4, le=4)]], Field(min_length=2, max_length=2)]


class TrackVelocityParameters(Typed):
    """Arguments of `TrackVelocity`."""

    robot: str = Field("unitree_g1", description="name of a robot that walks")
    forward_m_s: Span = Field([0.0, 1.0], description="goals, velocity ahead, [low, high], m/s")
    sideways_m_s: Span = Field([-0.5, 0.5], description="goals, to the left, [low, high], m/s")
    heading_rad: Span = Field(
        [-math.pi, math.pi], description="goals, heading relative to the start, [low, high], rad"
    )
    ratio: Number = Field(
        0.4, gt=0, le=1, description="success is a speed above it, as a share of the goal's"
    )


class Measured(NamedTuple):
    """What terms need of robots that walk, (n, …) each.

    Attributes:
        velocity: (n, 2) of the base over ground, ahead and to the left, m/s.
        linear, angular: (n, 3) of the base in its own frame, m/s and rad/s.
        gravity: (n, 3) where down is, in that frame.
        turning: (n,) of the base about the vertical, rad/s.
        command: (n, 3) velocity ahead and to the left, m/s, and turn rate, rad/s.
        stands: (n, nfoot) bool, whether a foot touches the ground.
        slip: (n, nfoot) horizontal speed of a foot that does, m/s.
        fallen: (n,) bool, whether the trunk touches anything.
        effort: (n,) Σ τ² of the legs, (N·m)².
        jerking: (n,) Σ q̈² of the legs, rad²/s⁴.
        held_s: (n, nfoot) for how long a foot stands or swings.
    """

    velocity: Array
    linear: Array
    angular: Array
    gravity: Array
    turning: Array
    command: Array
    stands: Array
    slip: Array
    fallen: Array
    effort: Array
    jerking: Array
    held_s: Array = None


def squares(vectors: Array) -> Array:
    """Σ v² of each row, (n,)."""
    return (vectors**2).sum(axis=1)


def too_slow(at: Moment) -> Array:
    """(n, 2) m/s, how the velocity over ground differs from the command."""
    return at.now.velocity - at.now.command[:, :2]


def too_little_turned(at: Moment) -> Array:
    """(n, 1) rad/s, how the turn rate does."""
    return (at.now.turning - at.now.command[:, 2])[:, None]


def tracked(error: Array) -> Array:
    """exp(−‖error‖² / 0.25) of (n, k) errors: 1 where there is none."""
    return namespace(error).exp(-squares(error) / OVER**2)


def stepping(at: Moment) -> Array:
    """How long the robot has stood on one foot, the other swinging, up to `STEP_S`."""
    xp, now = namespace(at.q), at.now
    single = indicator(now.stands).sum(axis=1) == 1
    asked = norm(now.command[:, :2]) > SLOW
    return indicator(single & asked) * xp.clip(xp.min(now.held_s, axis=1), None, STEP_S)


def off_home(joints: str) -> Callable[[Moment], Array]:
    """Σ |q − home| of joints of the robot's walker, rad."""

    def value(at: Moment) -> Array:
        own = at.task.columns_of(joints)
        home = like(at.task.robot.home[own], at.q)
        return namespace(at.q).abs(at.q[:, own] - home).sum(axis=1)

    return value


def beyond_soft(at: Moment) -> Array:
    """How far the ankles are beyond the soft ends of their ranges, rad."""
    own = at.task.columns_of("ankles")
    low, high = (like(end[own], at.q) for end in at.task.soft_limit)
    q, xp = at.q[:, own], namespace(at.q)
    return (xp.clip(low - q, 0.0, None) + xp.clip(q - high, 0.0, None)).sum(axis=1)


class TrackVelocity(Rewarded):
    """Success: ‖v‖ / ‖v_goal‖ over ground above `ratio` at the end of an episode, without a fall.

    The rule is the study's, and asks for no direction. A goal is a velocity and a heading, to which
    the robot is to turn.

    Raises:
        ConfigurationError: no such robot.
        ValueError: it does not walk; or a range is empty.
    """

    name = "track_velocity"
    instruction = "Walk with the velocity that is asked for."
    parameters = TrackVelocityParameters
    hyperparameters = "g1"
    steady = False
    # the template's
    least_rate_hz = 200.0
    on_gpu = True
    goal_size = 3
    rewards = (
        RewardTerm("velocity", 1.0, lambda at: tracked(too_slow(at)), TEMPLATE),
        RewardTerm("turn", 1.0, lambda at: tracked(too_little_turned(at)), TEMPLATE),
        RewardTerm("stepping", 0.75, stepping, TEMPLATE),
        RewardTerm("fall", 200.0, minus(lambda at: indicator(at.now.fallen)), TEMPLATE),
        RewardTerm("slip", 0.1, minus(lambda at: at.now.slip.sum(axis=1)), TEMPLATE),
        RewardTerm("ankles", 1.0, minus(beyond_soft), TEMPLATE),
        RewardTerm("hips", 0.1, minus(off_home("sideways")), TEMPLATE),
        RewardTerm("arms", 0.1, minus(off_home("arms")), TEMPLATE),
        RewardTerm("fingers", 0.05, minus(off_home("fingers")), TEMPLATE),
        RewardTerm("waist", 0.1, minus(off_home("waist")), TEMPLATE),
        RewardTerm("upright", 1.0, minus(lambda at: squares(at.now.gravity[:, :2])), TEMPLATE),
        RewardTerm("bouncing", 0.2, minus(lambda at: at.now.linear[:, 2] ** 2), TEMPLATE),
        RewardTerm("tilting", 0.05, minus(lambda at: squares(at.now.angular[:, :2])), TEMPLATE),
        RewardTerm("torque", 2e-6, minus(lambda at: at.now.effort), TEMPLATE),
        RewardTerm("acceleration", 1e-7, minus(lambda at: at.now.jerking), TEMPLATE),
        RewardTerm("change", 5e-3, minus(action_change), TEMPLATE),
    )
    terminations = (TerminationTerm("fallen", lambda at: at.now.fallen),)

    def __init__(
        self,
        robot: str,
        forward_m_s: tuple[float, float],
        sideways_m_s: tuple[float, float],
        heading_rad: tuple[float, float],
        ratio: float,
    ):
        self.robot, self.ratio = make_robot(robot), ratio
        if self.robot.walker is None:
            raise ValueError(f"robot: found {robot}, which does not walk; allowed: one that does")
        goals = {"forward_m_s": forward_m_s, "sideways_m_s": sideways_m_s,
                 "heading_rad": heading_rad}  # fmt: skip
        for key, (low, high) in goals.items():
            check_range(key, low, high)
        self.walker, self.goals = self.robot.walker, np.array(list(goals.values()))
        own = (
            *state_of(self.robot.joints),
            ObservationTerm(tuple(f"velocity.{c}" for c in "xyz"), lambda at: at.now.linear),
            ObservationTerm(tuple(f"turn.{c}" for c in "xyz"), lambda at: at.now.angular),
            ObservationTerm(tuple(f"down.{c}" for c in "xyz"), lambda at: at.now.gravity),
        )
        self.robot_observation_size = sum(len(term.names) for term in own)
        command = tuple(f"command.{c}" for c in ("x", "y", "turn"))
        self.observations = (*own, ObservationTerm(command, lambda at: at.now.command))

    def spec(self, visual: bool) -> mujoco.MjSpec:
        """The robot on flat ground, with sensors of its feet and its trunk."""
        return ground_scene(self.robot, visual)

    def sample_starts(self, rng, n):
        """See `Task.sample_starts`: upright at home, all the same, as in the template."""
        qpos = np.tile(self.model.qpos0, (n, 1))
        base = self.base_qpos.start
        qpos[:, base : base + 7] = (0, 0, self.walker.height_m, 1, 0, 0, 0)
        qpos[:, self.arm_qpos] = self.robot.home
        return qpos

    def sample_goals(self, rng, n):
        """See `Rewarded.sample_goals`: velocity ahead and to the left, m/s, and heading, rad."""
        return rng.uniform(*self.goals.T, (n, 3))

    def measure(self, batch, goal):
        """See `Rewarded.measure`."""
        sensed = batch.bind("sensordata")
        xp = namespace(sensed)
        twist = batch.qvel[:, self.base_dofs]
        rows = rotation_rows(batch.qpos[:, self.base_qpos][:, 3:])
        # MuJoCo has the base's velocity in the world's frame, and its turning in its own
        linear, angular = into_frame(rows, twist[:, :3]), xp.asarray(twist[:, 3:], copy=True)
        yaw = xp.atan2(rows[1][:, 0], rows[0][:, 0])
        cos, sin = xp.cos(yaw), xp.sin(yaw)
        velocity = xp.stack(
            [cos * twist[:, 0] + sin * twist[:, 1], cos * twist[:, 1] - sin * twist[:, 0]], axis=1
        )
        away = goal[:, 2] - yaw
        turn = xp.clip(TURNING * xp.atan2(xp.sin(away), xp.cos(away)), -FASTEST, FASTEST)
        force, moving = felt(sensed, len(self.walker.feet))
        touches = xp.linalg.vector_norm(force, axis=2) > CONTACT_N
        stands = touches[:, :-1]
        slip = indicator(stands) * xp.linalg.vector_norm(moving[:, :, :2], axis=2)
        legs = self._legs
        return Measured(
            velocity, linear, angular, -rows[2], (rows[2] * angular).sum(axis=1),
            xp.concat([goal[:, :2], turn[:, None]], axis=1),
            stands, slip, touches[:, -1],
            squares(batch.bind("actuator_force")[:, legs.actuators]),
            squares(batch.bind("qacc")[:, legs.dofs]),
        )  # fmt: skip

    def follow(self, now, before, elapsed_s, began):
        """See `Rewarded.follow`: how long feet stand or swing."""
        xp = namespace(now.linear)
        # of who begins sensors still tell the episode before
        for sensed in (now.stands, now.fallen, now.slip, now.effort, now.jerking):
            sensed[began] = 0
        if before is None:
            return now._replace(held_s=0.0 * now.slip)
        held = xp.where(now.stands == before.stands, before.held_s, 0.0) + elapsed_s
        held[began] = 0.0
        return now._replace(held_s=held)

    def success(self, at):
        """See `Rewarded.success`."""
        return norm(at.now.velocity) > self.ratio * norm(at.goal[:, :2])

    def columns_of(self, joints: str) -> np.ndarray:
        """Which of the robot's joints are those of its walker, such as `ankles`."""
        return self._columns[joints]

    @cached_property
    def _columns(self) -> dict[str, np.ndarray]:
        sets = ("legs", "ankles", "sideways", "arms", "fingers", "waist")
        index = self.robot.joints.index
        return {
            name: np.array([index(joint) for joint in getattr(self.walker, name)], int)
            for name in sets
        }

    @cached_property
    def soft_limit(self) -> tuple[np.ndarray, np.ndarray]:
        """(njoint,) lower and upper ends of what joints should keep to, rad."""
        low, high = self.robot.position_limit.T
        middle, half = (low + high) / 2, SOFT * (high - low) / 2
        return middle - half, middle + half

    @cached_property
    def base_qpos(self) -> slice:
        """Where qpos has the base's position and quaternion."""
        address = int(self.model.joint(self.walker.base).qposadr[0])
        return slice(address, address + 7)

    @cached_property
    def base_dofs(self) -> slice:
        """Where qvel has the base's velocity and turning."""
        address = int(self.model.joint(self.walker.base).dofadr[0])
        return slice(address, address + 6)

    @cached_property
    def _legs(self) -> "_Legs":
        own = self.columns_of("legs")
        return _Legs(columns(self.arm_dofs[own]), columns(self.arm_ctrl[own]))


class _Legs(NamedTuple):
    dofs: np.ndarray | slice
    actuators: np.ndarray | slice
