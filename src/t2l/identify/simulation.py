"""Variants of a plant simulated in one batch and read where the recordings were measured."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import mujoco
import numpy as np

from t2l.effects.blame import blaming
from t2l.effects.effect import Effect
from t2l.effects.term import Layout, Term
from t2l.identify.hidden_state import CLAMPED, SHARES, UNKNOWN, VELOCITY_S, WINDOW_S, Beginning
from t2l.sim.loop import Loop
from t2l.sim.schedule import Schedule
from t2l.sim.servo import ServoLoop


def simulate(
    model: mujoco.MjModel,
    joints: tuple[str, ...],
    schedule: Schedule,
    substeps: int,
    variants: Sequence[tuple[Layout, np.ndarray]],
    wanted: Sequence[np.ndarray],
    velocity: bool = False,
    threads: int = 1,
    beginning: Beginning | None = None,
    progress: Callable[[float], None] = lambda part: None,
) -> tuple[np.ndarray, ...]:
    """Position (m, k) of each variant at each wanted sample, NaN where it diverged.

    Args:
        substeps: physics steps a control tick are multiplied by this.
        variants: terms whose structure `model` has, and vectors u (mi, n) of their parameters; m
            is the sum of mi.
        wanted: of each sample its recording in the schedule, the index in `sample_ticks` of the
            tick at or before it, the fraction of a period since, and its joint; (k,) each.
        velocity: return that too, likewise.
        beginning: of the recordings.
        progress: told now and then which part of the ticks is done.
    """
    hidden = starts(model, joints, schedule, substeps, variants, threads, beginning)
    with blaming(_taking_part(variants), "to simulate it"):
        run = _run(model, joints, schedule, substeps, variants, threads, hidden, progress)
    between, rate = run.at(wanted)
    return (between, rate) if velocity else (between,)


def at_every_tick(
    model: mujoco.MjModel,
    joints: tuple[str, ...],
    schedule: Schedule,
    substeps: int,
    layout: Layout,
    u: np.ndarray,
    threads: int = 1,
    hidden: np.ndarray | None = None,
) -> tuple[np.ndarray, np.ndarray]:
    """What the encoders read and its velocity at the ticks of a schedule, (ntick, nrec, njoint).

    Args:
        u: (n,) parameters of `layout`.
        hidden: (1, nrec, njoint, k) of `starts`.
    """
    variants = [(layout, u[None])]
    ticks = np.arange(schedule.sample_ticks[-1] + 1)
    whole = replace(schedule, sample_ticks=ticks)
    with blaming(_taking_part(variants), "to simulate it"):
        run = _run(model, joints, whole, substeps, variants, threads, hidden)
    q, dq = run.at_ticks()
    return q[0].transpose(1, 0, 2), dq[0].transpose(1, 0, 2)


def starts(
    model: mujoco.MjModel,
    joints: tuple[str, ...],
    schedule: Schedule,
    substeps: int,
    variants: Sequence[tuple[Layout, np.ndarray]],
    threads: int,
    beginning: Beginning | None,
) -> np.ndarray | None:
    """How recordings start beyond what was measured, (m, nrec, njoint, k); None if that is all.

    Arguments as of `simulate`; see `Loop.hidden_start`.
    """
    if beginning is None:
        return None
    # one that begins where a motion turns looks as if it were at rest
    hiding = _hiding(variants) if schedule.may_move.any() else []
    terms = [term for layout, _ in variants for term in layout.terms]
    held, at_rest = holding(terms)
    swing = swinging(terms)
    estimated = (beginning.doubt > 0).any(axis=1) | bool(hiding or at_rest or swing)
    estimated |= schedule.may_move & bool(held)
    if not estimated.any():
        return None
    hidden = np.zeros((sum(len(u) for _, u in variants), *beginning.doubt.shape, UNKNOWN))
    beginning = replace(beginning, holds=schedule.may_move | at_rest)
    beginning = beginning.of(np.flatnonzero(estimated))
    memory_s = WINDOW_S if hiding or held else VELOCITY_S
    beginning = beginning.within(max(memory_s, beginning.half_s) if swing else memory_s)
    beginning = replace(beginning, memory_s=memory_s)
    unknown = hiding, held, CLAMPED if at_rest else SHARES, swing
    hidden[:, estimated] = _hidden(model, joints, beginning, substeps, variants, threads, unknown)
    return hidden


def _hidden(
    model,
    joints,
    beginning: Beginning,
    substeps,
    variants,
    threads,
    unknown: tuple[Sequence[int], Sequence[int], Sequence[float], Sequence[int]],
) -> np.ndarray:
    """How the recordings start, (m, nrec, njoint, k), as `Loop.hidden_start`.

    Args:
        unknown: joints with a far side, those that hold a torque, guesses of its share, and joints
            that swing freely.
    """
    m, (hiding, *held) = sum(len(u) for _, u in variants), unknown

    def predict(starts: np.ndarray) -> np.ndarray:
        copies = list(variants) * (len(starts) // m)
        run = _run(model, joints, beginning.schedule, substeps, copies, threads, starts)
        return run.at(beginning.wanted)[0]

    with blaming(_taking_part(variants), "to simulate it"):
        play = np.zeros((m, *beginning.doubt.shape))
        if hiding:
            loop = made_loop(model, joints, beginning.schedule, substeps, variants, threads)
            play = loop.transmission.play.reshape(play.shape)
        return beginning.estimate(predict, hiding, play, *held)


def _hiding(variants: Sequence[tuple[Layout, np.ndarray]]) -> list[int]:
    """Joints with a far side that no encoder sees."""
    terms = [term for layout, _ in variants for term in layout.terms if term.effect.hides_state]
    return sorted({joint for term in terms for joint in term.joints})


def holding(terms: Sequence[Term]) -> tuple[tuple[int, ...], bool]:
    """Joints that hold a torque which nobody knows at the start, and whether also from rest."""
    some = [term for term in terms if term.effect.holds_torque]
    joints = tuple(sorted({joint for term in some for joint in term.joints}))
    return joints, any(term.effect.holds_at_rest for term in some)


def swinging(terms: Sequence[Term]) -> tuple[int, ...]:
    """Joints with a phase that nobody knows."""
    return tuple(sorted({j for term in terms if term.effect.swings for j in term.joints}))


def acting_every(terms: Sequence[Term]) -> float:
    """The longest, s, from one time that all act to the next."""
    return min((term.effect.every_s for term in terms), default=np.inf)


def _taking_part(variants: Sequence[tuple[Layout, np.ndarray]]) -> list[Effect]:
    return [term.effect for layout, _ in variants for term in layout.terms]


@dataclass(frozen=True)
class _Run:
    """What a loop did at some ticks.

    Attributes:
        q, dq: (m, nrec, ntick, njoint) rad and rad/s.
        place: of each of the schedule's `sample_ticks`, among these; the next tick follows it.
        follows: (ntick,) bool, whether the tick after the next is there too.
        later_s: (m, nrec, njoint) s, by how much samples are later than their stamps.
    """

    q: np.ndarray
    dq: np.ndarray
    place: np.ndarray
    follows: np.ndarray
    later_s: np.ndarray
    period_s: float

    def at(self, wanted: Sequence[np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
        """Position and velocity at the wanted samples, (m, k)."""
        recording, tick, rest, joint = wanted
        tick = self.place[tick]
        if not self.later_s.any():
            return self._between((slice(None), recording), tick, rest, joint)
        rest = rest + self.later_s[:, recording, joint] / self.period_s
        beyond = self.follows[tick] & (rest >= 1)
        variant = np.arange(len(self.q))[:, None]
        return self._between((variant, recording), tick + beyond, rest - beyond, joint)

    def at_ticks(self) -> tuple[np.ndarray, np.ndarray]:
        """Position and velocity where the log's clock shows every tick, of a run over all ticks."""
        if not self.later_s.any():
            return self.q, self.dq
        m, nrec, ntick, njoint = self.q.shape
        recording, tick, joint = (i.ravel() for i in np.indices((nrec, ntick, njoint)))
        # of the last tick there is no next
        before = np.minimum(tick, ntick - 2)
        found = self.at((recording, before, (tick - before).astype(float), joint))
        q, dq = (values.reshape(m, nrec, ntick, njoint) for values in found)
        return q, dq

    def _between(self, of: tuple, tick, rest, joint) -> tuple[np.ndarray, np.ndarray]:
        first, second = (*of, tick, joint), (*of, tick + 1, joint)
        q, dq = self.q, self.dq
        between = hermite(rest, self.period_s, q[first], q[second], dq[first], dq[second])
        return between, (1 - rest) * dq[first] + rest * dq[second]


def _run(
    model,
    joints,
    schedule,
    substeps,
    variants,
    threads,
    hidden: np.ndarray | None = None,
    progress: Callable[[float], None] = lambda part: None,
) -> _Run:
    """Every variant, simulated."""
    loop = made_loop(model, joints, schedule, substeps, variants, threads)
    if hidden is not None:
        loop.hidden_start[:] = hidden.reshape(loop.hidden_start.shape)
    ticks = schedule.sample_ticks
    if loop.command_lead_s.any():
        # a sample may be later than the tick after its stamp
        ticks = np.union1d(ticks, ticks + 1)
        ticks = ticks[ticks <= schedule.sample_ticks[-1]]
        loop.schedule = replace(schedule, sample_ticks=ticks)
    q, dq = loop.run(progress)
    place = np.searchsorted(ticks, schedule.sample_ticks)
    follows = np.isin(ticks + 1, ticks) & np.isin(ticks + 2, ticks)
    later = loop.sampled_later_s.reshape(q.shape[0], q.shape[1], -1)
    return _Run(q, dq, place, follows, later, loop.period_s)


def made_loop(
    model: mujoco.MjModel,
    joints: tuple[str, ...],
    schedule: Schedule,
    substeps: int,
    variants: Sequence[tuple[Layout, np.ndarray]],
    threads: int,
) -> ServoLoop:
    """The loop of every variant, with their effects; arguments as of `simulate`."""
    m = sum(len(u) for _, u in variants)
    every_s = acting_every([term for layout, _ in variants for term in layout.terms])
    loop = ServoLoop(model, joints, schedule, m, threads, substeps, every_s)
    install(loop, variants)
    return loop


def install(loop: Loop, variants: Sequence[tuple[Layout, np.ndarray]]) -> None:
    """Give a loop the effects of its variants, u (mi, n) each, to each in its own order.

    A term of several variants that follow each other is installed once, as each acts at every tick.
    """
    counts = [len(u) for _, u in variants]
    first = np.concatenate([[0], np.cumsum(counts)])
    values = [layout.decode(u) for layout, u in variants]
    left = [list(layout.terms) for layout, _ in variants]
    while any(left):
        heads = dict.fromkeys(terms[0] for terms in left if terms)
        # one that no variant has further back, if there is such a one
        term = next(
            (t for t in heads if not any(t in terms[1:] for terms in left)), next(iter(heads))
        )
        having = np.array([bool(terms) and terms[0] == term for terms in left])
        for run in _runs(having):
            every = [values[i][term.effect.name] for i in run]
            whole = {key: np.concatenate([one[key] for one in every]) for key in every[0]}
            per_row = {key: loop.per_row(value) for key, value in whole.items()}
            simulations = loop.rows(slice(first[run[0]], first[run[-1] + 1]))
            before = {name: len(acting) for name, acting in loop.places.items()}
            term.effect.install(loop, simulations, np.array(term.joints, int), per_row)
            new = {name: acting[before[name] :] for name, acting in loop.places.items()}
            loop.in_order |= sum(map(bool, new.values())) > 1
            if term.effect.stateless:
                for name, acting in loop.stateless.items():
                    acting += new[name]
        for i in np.flatnonzero(having):
            del left[i][0]


def _runs(having: np.ndarray) -> list[np.ndarray]:
    """Indices of those (k,) that are true, in runs that follow each other."""
    found = np.flatnonzero(having)
    return np.split(found, np.flatnonzero(np.diff(found) > 1) + 1)


def hermite(
    part: np.ndarray, period: float, q0: np.ndarray, q1: np.ndarray, v0: np.ndarray, v1: np.ndarray
) -> np.ndarray:
    """Position at a part of the period between two ticks; exact under a held torque."""
    left, right = 1 - part, part
    return (
        (1 + 2 * right) * left**2 * q0
        + right**2 * (1 + 2 * left) * q1
        + period * (right * left**2 * v0 - right**2 * left * v1)
    )
