"""Track-Velocity: walk on flat ground with the velocity that is asked for; by learning.

Terms, weights, goals and the ending are those of IsaacLab's manager-based velocity environment
(G1, flat), from which the study's task is derived (App. E). The success rule is the study's.
"""

import math
from functools import cached_property
from typing import Annotated, NamedTuple

import mujoco
import numpy as np
from pydantic import Field

from t2l.robots import make_robot
from t2l.sim.arrays import Array, columns, like, namespace
from t2l.sim.batch import TIMESTEP_S
from t2l.tasks.table_top import STANDS, check_range, stage_lights
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
        linear, angular, gravity: (n, 3) of the base in its own frame: m/s, rad/s, and where down is.
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


def tracked(error: Array) -> Array:
    """exp(−‖error‖² / 0.25) of (n, k) errors: 1 where there is none."""
    return namespace(error).exp(-(error**2).sum(axis=1) / OVER**2)


def stepping(at: Moment) -> Array:
    """How long the robot has stood on one foot, the other swinging, up to `STEP_S`."""
    xp, now = namespace(at.q), at.now
    single = indicator(now.stands).sum(axis=1) == 1
    asked = norm(now.command[:, :2]) > SLOW
    return indicator(single & asked) * xp.clip(xp.min(now.held_s, axis=1), None, STEP_S)


def off_home(joints: str):
    """Σ |q − home| of joints of the robot's walker, rad: what costs."""

    def value(at: Moment) -> Array:
        own = at.task.columns_of(joints)
        home = like(at.task.robot.home[own], at.q)
        return -namespace(at.q).abs(at.q[:, own] - home).sum(axis=1)

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
    goal_size = 3
    rewards = (
        RewardTerm("velocity", 1.0, lambda at: tracked(at.now.velocity - at.now.command[:, :2]),
                   TEMPLATE),
        RewardTerm("turn", 1.0, lambda at: tracked((at.now.turning - at.now.command[:, 2])[:, None]),
                   TEMPLATE),
        RewardTerm("stepping", 0.75, stepping, TEMPLATE),
        RewardTerm("fall", 200.0, minus(lambda at: indicator(at.now.fallen)), TEMPLATE),
        RewardTerm("slip", 0.1, minus(lambda at: at.now.slip.sum(axis=1)), TEMPLATE),
        RewardTerm("ankles", 1.0, minus(beyond_soft), TEMPLATE),
        RewardTerm("hips", 0.1, off_home("sideways"), TEMPLATE),
        RewardTerm("arms", 0.1, off_home("arms"), TEMPLATE),
        RewardTerm("fingers", 0.05, off_home("fingers"), TEMPLATE),
        RewardTerm("waist", 0.1, off_home("waist"), TEMPLATE),
        RewardTerm("upright", 1.0, minus(lambda at: (at.now.gravity[:, :2] ** 2).sum(axis=1)),
                   TEMPLATE),
        RewardTerm("bouncing", 0.2, minus(lambda at: at.now.linear[:, 2] ** 2), TEMPLATE),
        RewardTerm("tilting", 0.05, minus(lambda at: (at.now.angular[:, :2] ** 2).sum(axis=1)),
                   TEMPLATE),
        RewardTerm("torque", 2e-6, minus(lambda at: at.now.effort), TEMPLATE),
        RewardTerm("acceleration", 1e-7, minus(lambda at: at.now.jerking), TEMPLATE),
        RewardTerm("change", 5e-3, minus(action_change), TEMPLATE),
    )  # fmt: skip
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
        spec, walker = self.robot.spec(gravity_compensation=False, visual=visual), self.walker
        spec.option.timestep = TIMESTEP_S
        spec.option.integrator = mujoco.mjtIntegrator.mjINT_DISCRETE
        spec.worldbody.add_geom(
            name=GROUND, type=mujoco.mjtGeom.mjGEOM_PLANE, size=(0, 0, 0.05), **STANDS
        )
        for body in (*walker.feet, walker.trunk):
            # the force of all contacts together, as IsaacLab's sensor has it
            spec.add_sensor(
                name=f"contact.{body}", type=mujoco.mjtSensor.mjSENS_CONTACT,
                objtype=mujoco.mjtObj.mjOBJ_BODY, objname=body, intprm=(FORCE, NET, 1),
            )  # fmt: skip
        for body in walker.feet:
            spec.add_sensor(
                name=f"velocity.{body}", type=mujoco.mjtSensor.mjSENS_FRAMELINVEL,
                objtype=mujoco.mjtObj.mjOBJ_XBODY, objname=body,
            )  # fmt: skip
        if visual:
            _stage(spec, spec.joint(walker.base).parent)
        return spec

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
        rows = _rotation(batch.qpos[:, self.base_qpos][:, 3:])
        # MuJoCo has the base's velocity in the world's frame, and its turning in its own
        linear, angular = _into(rows, twist[:, :3]), xp.asarray(twist[:, 3:], copy=True)
        yaw = xp.atan2(rows[1][:, 0], rows[0][:, 0])
        cos, sin = xp.cos(yaw), xp.sin(yaw)
        velocity = xp.stack(
            [cos * twist[:, 0] + sin * twist[:, 1], cos * twist[:, 1] - sin * twist[:, 0]], axis=1
        )
        away = goal[:, 2] - yaw
        turn = xp.clip(TURNING * xp.atan2(xp.sin(away), xp.cos(away)), -FASTEST, FASTEST)
        feet = len(self.walker.feet)
        pushed = xp.reshape(sensed[:, : 3 * (feet + 1)], (-1, feet + 1, 3))
        touches = xp.linalg.vector_norm(pushed, axis=2) > CONTACT_N
        moving = xp.reshape(sensed[:, 3 * (feet + 1) :], (-1, feet, 3))[:, :, :2]
        legs = self._legs
        return Measured(
            velocity, linear, angular, -rows[2], (rows[2] * angular).sum(axis=1),
            xp.concat([goal[:, :2], turn[:, None]], axis=1),
            touches[:, :feet],
            indicator(touches[:, :feet]) * xp.linalg.vector_norm(moving, axis=2),
            touches[:, feet],
            (batch.bind("actuator_force")[:, legs.actuators] ** 2).sum(axis=1),
            (batch.bind("qacc")[:, legs.dofs] ** 2).sum(axis=1),
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

    def paid(self, at):
        """See `Rewarded.paid`: the template's weights are of a second."""
        return [at.period_s * term for term in super().paid(at)]

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


GROUND = "ground"
# format: of MuJoCo's contact sensor, what it tells (bit of the force) and how contacts are reduced
FORCE, NET = 2, 3


def _rotation(quaternion: Array) -> tuple[Array, Array, Array]:
    """Rows (n, 3) of the rotation of (n, 4) quaternions, w first."""
    xp, (w, x, y, z) = namespace(quaternion), (quaternion[:, i] for i in range(4))
    return (
        xp.stack([1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)], axis=1),
        xp.stack([2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)], axis=1),
        xp.stack([2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)], axis=1),
    )


def _into(rows: tuple[Array, Array, Array], vector: Array) -> Array:
    """(n, 3) vectors of the world in the frame whose rotation has these rows."""
    return sum(row * vector[:, i, None] for i, row in enumerate(rows))


def _stage(spec: mujoco.MjSpec, body: mujoco.MjsBody) -> None:
    """Light, tiles of half a metre, and a camera before a body, to its right, that goes with it."""
    stage_lights(spec)
    # it is to shine wherever the robot goes
    spec.lights[-1].type = mujoco.mjtLightType.mjLIGHT_DIRECTIONAL
    spec.add_texture(
        name=GROUND, type=mujoco.mjtTexture.mjTEXTURE_2D, width=128, height=128,
        builtin=mujoco.mjtBuiltin.mjBUILTIN_CHECKER,
        rgb1=(0.93, 0.92, 0.90), rgb2=(0.86, 0.85, 0.83),
    )  # fmt: skip
    tiles = spec.add_material(name=GROUND, texuniform=True, texrepeat=(1, 1))
    tiles.textures[mujoco.mjtTextureRole.mjTEXROLE_RGB] = GROUND
    spec.geom(GROUND).material = GROUND
    body.add_camera(
        name="overview", mode=mujoco.mjtCamLight.mjCAMLIGHT_TRACK, pos=(1.7, -1.35, 0.2),
        xyaxes=(0.62, 0.78, 0, -0.1, 0.08, 0.99), fovy=42,
    )  # fmt: skip
