"""Terms that a task of reinforcement learning is composed of, as in IsaacLab and mjlab.

A term is a function of a `Moment`, all simulations of a batch at once, under a name. So a task says
what a policy sees, what is paid and what ends an episode by tuples that are read line by line, and
what one task has another one may use:

    rewards = (
        RewardTerm("reaching", 1.0, lambda at: nearness(at.now.reach_m, 0.1), "IsaacLab"),
        RewardTerm("velocity", 1e-4, minus(speed), "IsaacLab"),
    )

A step pays Σ weight · value · period, so weights are of a second. They are positive, so that they
can be searched by their logarithms; what costs has negative values.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from mujoco.batch import Batch

from t2l.sim.arrays import Array, namespace

if TYPE_CHECKING:
    from t2l.tasks.task import Rewarded


@dataclass(frozen=True, eq=False)
class Moment:
    """`n` simulations at the end of a policy's period.

    Attributes:
        task: theirs, with its weights and tolerances.
        batch: all there is of them: bodies, objects, contacts, sensors.
        q, dq: (n, njoint) rad and rad/s, of the robot; as they are measured in what is observed.
        goal: (n, goal_size).
        now, before: what `Rewarded.measure` and `follow` made of the simulations, and a period ago.
        action, change: (n, naction) the last action, and how it differs from the one before.
        period_s: of the policy.
        steps: of the training until then, of all its robots.
    """

    task: "Rewarded"
    batch: Batch
    q: Array
    dq: Array
    goal: Array
    now: Any
    before: Any = None
    action: Array = None
    change: Array = None
    period_s: float = 0.0
    steps: int = 0


@dataclass(frozen=True)
class ObservationTerm:
    """What a policy sees: (n, k) numbers with a name each."""

    names: tuple[str, ...]
    value: Callable[[Moment], Array]


@dataclass(frozen=True)
class RewardTerm:
    """What is paid, (n,) a second.

    Attributes:
        weight: of a second, unless tuning chooses another.
        source: where form and weight are from.
        curriculum: after how many steps of a training, counted over all its robots, the weight is
            multiplied, and by what.
    """

    name: str
    weight: float
    value: Callable[[Moment], Array]
    source: str
    curriculum: tuple[int, float] = (0, 1.0)

    def factor(self, steps: int) -> float:
        """What the weight is multiplied by after `steps` of a training."""
        after, factor = self.curriculum
        return factor if steps >= after else 1.0


@dataclass(frozen=True)
class TerminationTerm:
    """What ends an episode as a failure, (n,) bool; its length ends it anyhow."""

    name: str
    value: Callable[[Moment], Array]


def minus(value: Callable[[Moment], Array]) -> Callable[[Moment], Array]:
    """The cost of something."""
    return lambda at: -value(at)


def norm(vectors: Array) -> Array:
    """Of each row, (n,)."""
    return namespace(vectors).linalg.vector_norm(vectors, axis=1)


def nearness(away: Array, over: float) -> Array:
    """1 − tanh(away / over): 1 there, and little beyond `over`, (n,); IsaacLab's."""
    return 1 - namespace(away).tanh(away / over)


def indicator(true: Array) -> Array:
    """1 or 0."""
    return namespace(true).where(true, 1.0, 0.0)


def speed(at: Moment) -> Array:
    """Σ q̇² of the joints, rad²/s²; IsaacLab's `joint_vel_l2`."""
    return (at.dq**2).sum(axis=1)


def action_change(at: Moment) -> Array:
    """Σ Δa² of an action's elements; IsaacLab's `action_rate_l2`."""
    return (at.change**2).sum(axis=1)


def state_of(joints: Sequence[str]) -> tuple[ObservationTerm, ObservationTerm]:
    """Positions and velocities of the robot's joints, rad and rad/s: what every policy sees."""
    return (
        ObservationTerm(tuple(f"q.{joint}" for joint in joints), lambda at: at.q),
        ObservationTerm(tuple(f"dq.{joint}" for joint in joints), lambda at: at.dq),
    )
