"""What a physical effect is to t2l: parameters, and how they enter the simulation."""

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from copy import copy
from dataclasses import dataclass, fields, replace

import mujoco
import numpy as np

from t2l.effects.exported import Exported
from t2l.effects.expression import evaluate, parse
from t2l.recordings.recording import Recording
from t2l.sim.servo import ServoLoop

AT_REST_RAD_S = 0.02  # tuned: a slower joint is held where it is, and moves in no direction

Values = Mapping[str, np.ndarray]


@dataclass(frozen=True)
class Parameter:
    """A number that an effect adds to the model.

    Attributes:
        unit: SI, as written in reports.
        lower, upper: bounds of the fit. A lower one of minus infinity is for what `adds_to`.
        scale: what bounds and size are multiples of: a formula in the names of `Scales`, such as
            ``torque / velocity``. Without one they are numbers in `unit`. See `in_units`.
        adds_to: the field of MjModel, (nv,), whose value of a joint it adds to. What a robot has in
            all stays positive: see `within`.
        meaning: what it is, in a few words.
        neutral: the value at which the effect is absent (may be infinite); NaN if at none.
        log: fitted by its logarithm (positive quantities that span decades).
        per_joint: one value a joint; otherwise one for the robot.
        rough: the error jumps with it, so that no derivative helps.
        kinked: the error has kinks over it, as where a joint begins to stick; a derivative must
            look across them.
        size: a value that makes a difference, for derivatives where first guesses are zero.
        default: what a model file means that does not say it; NaN if it must.
    """

    name: str
    unit: str
    lower: float | tuple[float, ...]
    upper: float | tuple[float, ...]
    meaning: str
    neutral: float = 0.0
    log: bool = False
    per_joint: bool = True
    rough: bool = False
    kinked: bool = False
    size: float | tuple[float, ...] = 0.0
    adds_to: str = ""
    scale: str | float | tuple[float, ...] = ""
    default: float = np.nan

    def in_units(self, sizes: "Scales | None" = None) -> "Parameter":
        """The same with bounds, size and scale in `unit`, a number a joint.

        A parameter of the robot has one number, by the joint where the scale is largest. Where
        sizes are not known, bounds are what is possible at all, by the sign of the stated ones.
        """
        if not isinstance(self.scale, str) or not self.scale:
            return self
        if sizes is None:
            lower = 0.0 if self.lower >= 0 else -np.inf
            return replace(self, lower=lower, upper=np.inf, size=0.0, scale=1.0)
        scale = sizes.of(self.scale)
        scale = scale if self.per_joint else scale.max(keepdims=True)
        stated = {key: getattr(self, key) for key in ("lower", "upper", "size")}
        multiples = {key: tuple((value * scale).tolist()) for key, value in stated.items()}
        return replace(self, scale=tuple(scale.tolist()), **multiples)


@dataclass(frozen=True)
class Scales:
    """Sizes that the recordings and the model give, for bounds and first guesses; (njoint,) each.

    Those that bounds are multiples of are above zero. Of a slide read N, kg and m.

    Attributes:
        torque: RMS of the motor torque the model spends, N·m; at least of the weight, and what
            stops the joint in a second.
        inertia: diagonal of the mass matrix at the start, kg·m².
        velocity: RMS of the joint velocity, rad/s.
        peak_torque, peak_torque_rate: largest of them, N·m and N·m/s.
        total_torque: `torque` of all joints together, N·m.
        mass: of all that the joint moves, kg.
        control_rate_hz: the loop's rate by the log.
        range, centre: rad, how far the joint moves, and its mean position.
        kp, kd: largest gains over the recordings; where there is none, those of a loop of 1 Hz.
        armature, friction, damping: what the MJCF has already, kg·m², N·m and N·m·s/rad.
        plant: the robot without effects, for what an effect wants to know of its shape.
        joints: names of the driven joints.
    """

    torque: np.ndarray
    inertia: np.ndarray
    velocity: np.ndarray
    peak_torque: np.ndarray
    peak_torque_rate: np.ndarray
    total_torque: np.ndarray
    mass: np.ndarray
    control_rate_hz: float
    range: np.ndarray
    centre: np.ndarray
    kp: np.ndarray
    kd: np.ndarray
    armature: np.ndarray
    friction: np.ndarray
    damping: np.ndarray
    plant: mujoco.MjModel
    joints: tuple[str, ...]

    def of(self, formula: str) -> np.ndarray:
        """(njoint,) of a formula in the names of these sizes, such as ``torque / velocity``.

        Raises:
            ValueError: it is no formula of them.
        """
        sizes = {name: getattr(self, name) for name in SIZES}
        return evaluate(parse(formula, SIZES), np.zeros(len(self.joints)), sizes)


# that a formula may hold
SIZES = tuple(field.name for field in fields(Scales) if field.type is np.ndarray)


class Effect(ABC):
    """One physical effect. Subclass it in a file of its own; see docs/extending.md for an example.

    Class attributes:
        name: what users type.
        title: what reports print.
        parameters: the numbers it adds.
        summary: what it is and what it does to a torque or a signal, in a sentence.
        signature: how it shows in a recording, in a sentence that can follow "because".
        source: where its equation comes from.
        contains: effects that it becomes for some values of its parameters.
        does_too: effects that do on a joint what it does already for some values of its parameters:
            no set has both there, as their sizes could be anything.
        follows: the condition (see `t2l.diagnose.conditions`) that its error follows.
        coupled: a joint's parameters move other joints about as much as its own, so that each
            joint's derivatives take simulations of their own.
        shares: what it does to a joint depends on the torques of other joints.
        needs: optional columns that the recordings must have for it to be fitted.
        acts_through: gains, "kp" or "kd", of which a recording without commanded positions must
            have one: of torques alone, a late command cannot be told from a late torque.
        least_joints: how many driven joints it takes.
        remembers: what it does at a tick depends on ticks before.
        hides_state: it has a far side that no encoder sees, which need not start at rest.
        holds_torque: what it remembers is a torque, which a recording that begins in motion may
            begin with; `holds_at_rest`: or any recording, as far as friction balances it.
        swings: it has a phase of its own that nobody knows where a recording begins, see
            `oscillation`.
        reads: further arguments that `read_off` takes by name, (n,) each: `motor`, the motor torque
            of the logged commands and gains in N·m, `velocity` in rad/s, and `recording`, of
            which one each sample is.
        names_joints: its title says already which joints it is on.
        prior: (m, p) rows over a joint's parameters, whose products with these are about one or
            less: what fits keep small where recordings say nothing.
        order: effects on the same signal apply in this order, command to joint, each to what those
            before it left.
        every_s: s, the longest from one time that it acts between controller and joint to the next.
    """

    name: str
    title: str
    parameters: tuple[Parameter, ...]
    summary: str
    signature: str
    source: str
    contains: tuple[str, ...] = ()
    does_too: tuple[str, ...] = ()
    follows: str = ""
    coupled: bool = False
    shares: bool = False
    needs: tuple[str, ...] = ()
    acts_through: tuple[str, ...] = ()
    least_joints: int = 1
    remembers: bool = True
    hides_state: bool = False
    holds_torque: bool = False
    holds_at_rest: bool = False
    swings: bool = False
    reads: tuple[str, ...] = ()
    names_joints: bool = False
    prior: np.ndarray | None = None
    order: int = 0
    every_s: float = np.inf

    def extend(self, spec: mujoco.MjSpec, joints: tuple[str, ...]) -> None:
        """Add to the plant's MjSpec what the effect on `joints` needs; by default nothing."""
        return

    def export(self, to: Exported, joints: np.ndarray, values: Values) -> None:
        """Write the effect into plain MJCF, and a callback where MuJoCo has no element for it.

        Args:
            joints: (k,) indices into `to.joints`.
            values: for each parameter (k,), or one number if it is not per joint.
        """
        to.cannot_carry(self.name, "the effect does not say how it is exported")

    def held(self, values: Values) -> tuple[np.ndarray, np.ndarray]:
        """What it may hold at the start, where it `holds_torque`.

        Returns:
            N·m (nrow, k) at most, and rad likewise of motion that leave little of it.
        """
        raise NotImplementedError

    def oscillation(self, values: Values) -> tuple[np.ndarray, np.ndarray]:
        """Of the torque A sin(2π f t + φ) on each joint, where it `swings`: A and f.

        t is the time since the start; `install` reads φ off `Loop.hidden_start`, at `PHASE`.

        Returns:
            N·m and Hz, (nrow, k) each.
        """
        raise NotImplementedError

    @abstractmethod
    def install(self, loop: ServoLoop, rows: slice, joints: np.ndarray, values: Values) -> None:
        """Write the parameters into `loop`: expanded fields of its batch, filters, torques.

        Args:
            rows: the simulations that have the effect.
            joints: (k,) indices, into `loop.joints`, of the joints that have it.
            values: for each parameter (nrow, k), or (nrow, 1) if it is not per joint.
        """

    @abstractmethod
    def starts(self, scales: Scales) -> list[dict[str, np.ndarray]]:
        """First guesses to scan, each parameter as (njoint,) or (1,); at least one."""

    def read_off(
        self, q: np.ndarray, torque: np.ndarray, clock_s: np.ndarray
    ) -> dict[str, float] | None:
        """A further guess for one joint, from the torque that it lacks; by default none.

        Args:
            q: (n,) rad, measured.
            clock_s: (n,) s, what the log's clock showed.
            torque: (n,) N·m there beyond the model's, with noise and all else that is missing.
        """
        return None

    def also(self, guess: dict[str, np.ndarray]) -> list[dict[str, np.ndarray]]:
        """Further guesses that one that was read off each joint leads to; by default none.

        Args:
            guess: each parameter (njoint,).
        """
        return []

    def may_act(self, recordings: Sequence[Recording]) -> bool:
        """Whether the recordings have what it takes to fit it."""
        enough = len(recordings[0].joints) >= self.least_joints
        if self.acts_through and all(r.drifts for r in recordings):
            gains = [getattr(r, gain) for r in recordings for gain in self.acts_through]
            enough = enough and any(gain.any() for gain in gains)
        return enough and all(r.has(column) for column in self.needs for r in recordings)

    def places(self, joints: Sequence[str]) -> tuple[int, ...]:
        """Indices of the driven joints that may have it; by default of all."""
        return tuple(range(len(joints)))

    def check(self, joints: Sequence[str], values: Mapping[str, Mapping[str, float]]) -> None:
        """Find what no robot with these driven joints can have; by default nothing.

        Args:
            values: of each parameter, by joint where it has one a joint.

        Raises:
            ValueError: parameter and joint, what was found and what is allowed.
        """
        return

    @property
    def stateless(self) -> bool:
        """Whether what it does at a tick follows from what the loop and the plant do there."""
        return not (self.remembers or self.extends)

    @property
    def extends(self) -> bool:
        """Whether it changes the structure of the model."""
        return type(self).extend is not Effect.extend


def within(
    effect: Effect,
    model: mujoco.MjModel,
    joints: tuple[str, ...],
    sizes: Scales | None = None,
    stated: Mapping[str, Mapping[str, float] | float] | None = None,
) -> Effect:
    """`effect` with bounds in units that leave `joints` of a plant what is physically possible.

    What a parameter adds to is taken away as a whole at most: no fit makes a negative inertia,
    friction or damping of which the simulation would see zero.

    Args:
        sizes: of the recordings; without them, scaled bounds are what is possible at all.
        stated: values by parameter, which scaled bounds are to contain.
    """
    if not any(parameter.adds_to or parameter.scale for parameter in effect.parameters):
        return effect
    dofs = [model.joint(name).dofadr[0] for name in joints]

    def bounded(parameter: Parameter) -> Parameter:
        found = parameter.in_units(sizes)
        count = len(joints) if parameter.per_joint else 1
        lower, upper = (np.array(np.broadcast_to(b, count)) for b in (found.lower, found.upper))
        if parameter.scale and stated:
            value = stated[parameter.name]
            each = [value.get(n, np.nan) for n in joints] if parameter.per_joint else [value]
            lower, upper = np.fmin(lower, each), np.fmax(upper, each)
        if parameter.adds_to:
            lower = np.maximum(lower, -getattr(model, parameter.adds_to)[dofs])
        return replace(found, lower=tuple(lower.tolist()), upper=tuple(upper.tolist()))

    bounded_effect = copy(effect)
    bounded_effect.parameters = tuple(
        bounded(p) if p.adds_to or p.scale else p for p in effect.parameters
    )
    return bounded_effect
