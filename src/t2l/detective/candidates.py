"""What may be missing: known effects on one joint or on all, each with columns of responses.

A candidate's response is affine in its parameters: what it does at a setting, and the derivatives
there. Each of an effect's first guesses is a setting. On each joint the best is kept, the best
beside other effects, and the best for each value of what has no derivative. Of an effect of the
whole robot all are kept.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence, Set
from dataclasses import dataclass, field, replace

import numpy as np

from t2l.detective.free_phases import FreePhases, with_phase
from t2l.detective.linear_loop import Section, respond
from t2l.detective.responses import added_torques
from t2l.effects.blame import described, shipped
from t2l.effects.effect import Effect
from t2l.effects.term import Layout, Slot, Term
from t2l.errors import EffectError
from t2l.identify.prediction import Predictor

# numerics: of finite differences along a motion, which has no noise of its own
RELATIVE_STEP = 0.02
KEPT = 2  # numerics: settings of an effect on a joint that go on to the screen
FARTHEST = 1.0  # numerics: of a logarithm, beyond which a derivative tells nothing
NOWHERE = 1e-6  # numerics: rad; a smaller response is none
# numerics: responses that are taken off what is missing, to rank settings beside others
PURSUED = 3
TINY = 1e-30  # numerics: in place of a response that is none

Values = Mapping[str, np.ndarray]


@dataclass(frozen=True)
class Column:
    """A derivative by one number.

    Attributes:
        at: index into the columns of a table.
        parameter, joint: of the effect; no joint where it is the robot's or all joints'.
        lower, upper: how far u may move from the setting.
    """

    at: int
    parameter: str
    joint: int | None
    lower: float
    upper: float


@dataclass(frozen=True)
class Candidate:
    """An effect on some joints at a setting.

    Attributes:
        setting: u by (parameter, joint).
        constants: indices of columns that it adds as they are.
        columns: those that are weighted.
        numbers: of parameters, where it has more than columns.
        removal: it takes an effect away that the model has, on all its joints; `without` are the
            places in `Table.base` of the columns that go with it.
    """

    effect: Effect
    joints: tuple[int, ...]
    setting: dict[tuple[str, int | None], float]
    constants: tuple[int, ...]
    columns: tuple[Column, ...]
    numbers: int = 0
    removal: bool = False
    without: tuple[int, ...] = ()

    @property
    def complexity(self) -> int:
        """How many numbers it fits, less what it takes away; its name counts as one."""
        if self.removal:
            return -self.numbers - 1
        return max(self.numbers, len(self.columns), 1) + 1

    @property
    def prior(self) -> tuple[list[int], np.ndarray]:
        """Columns that its effect's prior tells something of, and its rows over them."""
        rows = self.effect.prior
        if rows is None:
            return [], np.zeros((0, 0))
        names = [parameter.name for parameter in self.effect.parameters]
        at = [names.index(column.parameter) for column in self.columns]
        return [column.at for column in self.columns], rows[:, at]

    @property
    def key(self) -> tuple[str, tuple[int, ...]]:
        """Effect and joints, whatever the setting."""
        return self.effect.name, self.joints

    def is_new_to(self, on: Mapping[str, Set[int]]) -> bool:
        """Whether it is an effect that a set lacks, or lacks on these joints.

        Args:
            on: joints of each effect that the set has.
        """
        parameters, name = self.effect.parameters, self.effect.name
        if self.removal:
            return False
        if name not in on:
            # what it would share with joints that have it in the model, it does not say
            said = {parameter for parameter, _ in self.setting}
            return all(parameter.name in said for parameter in parameters)
        return any(p.per_joint for p in parameters) and not on[name] & set(self.joints)

    def moved(self, by: int) -> "Candidate":
        """The same with its columns at other places, so many further."""
        columns = tuple(replace(column, at=column.at + by) for column in self.columns)
        return replace(self, columns=columns, constants=tuple(c + by for c in self.constants))

    def __repr__(self) -> str:
        where = ",".join(map(str, self.joints))
        return f"{'-' * self.removal}{self.effect.name}[{where}]"


def do_the_same(one: Candidate | Term, other: Candidate | Term) -> bool:
    """Whether an effect does what another does, see `Effect.does_too`, on a joint of both."""
    names = one.effect.name, other.effect.name
    does = names[0] in other.effect.does_too or names[1] in one.effect.does_too
    return does and bool(set(one.joints) & set(other.joints))


@dataclass
class Table:
    """Columns of responses, and the candidates that are made of them.

    Attributes:
        columns: (nsample, m), as far as products of them are not known, see `Screen`.
        base: indices of the columns that every set has: derivatives by the model so far.
        bounds: (p, 2) how far its parameters may move.
        prior, tending: (m, p) rows over how far they move, and (m,) what their products with it
            tend to, see `Effect.prior`.
    """

    columns: np.ndarray
    candidates: list[Candidate]
    base: tuple[int, ...] = ()
    bounds: np.ndarray = field(default_factory=lambda: np.zeros((0, 2)))
    prior: np.ndarray = field(default_factory=lambda: np.zeros((0, 0)))
    tending: np.ndarray = field(default_factory=lambda: np.zeros(0))


@dataclass
class _Asked:
    """Variants of one effect, whose torques are wanted.

    Attributes:
        settings: u (s, n) of a layout with the adopted terms.
        own: indices of the effect's own slots.
        steps: (s, n own) of finite differences.
        apart: it is on one joint more, as it moves others too; else on all, each answered by its
            own torque.
        torque: by section, (ntick, s (1 + p), nrec, n) N·m.
        phase: (s, nrecording, n) rad, of what swings.
    """

    effect: Effect
    term: Term
    layout: Layout
    settings: np.ndarray
    own: list[int]
    steps: np.ndarray
    apart: bool
    torque: list[np.ndarray] = field(default_factory=list)
    phase: np.ndarray | None = None

    @property
    def variants(self) -> np.ndarray:
        """(s (1 + p), n): each setting, followed by a step of each own slot group."""
        rows = []
        for u, step in zip(self.settings, self.steps, strict=True):
            rows.append(u)
            for group in self.groups:
                moved = u.copy()
                moved[group] += step[[self.own.index(i) for i in group]]
                rows.append(moved)
        return np.array(rows)

    @property
    def rows(self) -> range:
        """Of `variants`, the settings themselves."""
        width = 1 + len(self.groups)
        return range(0, width * len(self.settings), width)

    @property
    def groups(self) -> list[list[int]]:
        """Own slots that are moved together: of a parameter, all joints'."""
        found: dict[str, list[int]] = {}
        for i in self.own:
            slot = self.layout.slots[i]
            if not slot.parameter.rough:
                found.setdefault(slot.parameter.name, []).append(i)
        return list(found.values())

    @property
    def new_joints(self) -> list[int]:
        """That do not have the effect yet."""
        return sorted({self.layout.slots[i].joint for i in self.own} - {None})

    @property
    def each(self) -> list[int | None]:
        """Joints of which each makes a candidate; None where all are one."""
        per_joint = any(parameter.per_joint for parameter in self.effect.parameters)
        return self.new_joints if per_joint and not self.apart else [None]

    @property
    def shared(self) -> bool:
        """Whether its joints may have the same numbers, which makes a candidate beside."""
        own = [parameter for parameter in self.effect.parameters if parameter.per_joint]
        return len(self.each) > 1 and not any(p.scale or p.rough for p in own)

    def kept(self, ranked: Sequence[int], clearer: Sequence[int]) -> list[int]:
        """Of settings those that go on to the screen: the best, and the best beside others.

        Of an effect of the whole robot all do: they are few.

        Args:
            ranked: by what they leave of all that is missing, the best first.
            clearer: by what they leave of what others do not explain.
        """
        if not any(parameter.per_joint for parameter in self.effect.parameters):
            return list(ranked)
        rough = [i for i in self.own if self.layout.slots[i].parameter.rough]
        # where there is no derivative, no setting leads to another
        ways = {tuple(self.settings[s, rough]): s for s in reversed(ranked)}
        both = dict.fromkeys(s for pair in zip(ranked, clearer, strict=True) for s in pair)
        return [*dict.fromkeys([*[*both][:KEPT], *ways.values()])]

    def of_term(self, u: np.ndarray) -> np.ndarray:
        """Of u (m, n) what is the effect's, on all joints that have it."""
        return u[:, [i for i, slot in enumerate(self.layout.slots) if slot.term is self.term]]

    def of(self, joint: int | None, slots: Sequence[int]) -> list[int]:
        """Of some own slots those of a candidate on `joint`."""
        joints = (joint, None)
        return [i for i in slots if joint is None or self.layout.slots[i].joint in joints]

    def setting(self, s: int, joint: int | None) -> dict[tuple[str, int | None], float]:
        """u of setting s, by parameter and joint."""
        slots = self.layout.slots
        return {
            (slots[i].parameter.name, slots[i].joint): float(self.settings[s, i])
            for i in self.of(joint, self.own)
        }


def known_candidates(
    predictor: Predictor,
    sections: Sequence[Section],
    adopted: tuple[Layout, np.ndarray],
    effects: Sequence[Effect],
    guesses: Mapping[str, Sequence[Values]],
    residual: np.ndarray,
    rows: np.ndarray,
) -> Table:
    """Every effect as candidates, with columns at samples of the predictor.

    Args:
        guesses: of each effect by name, each parameter (njoint,) or (1,).
        residual: (nsample,) measured minus predicted, rad, of which settings tell the most.
        rows: (k,) indices of the samples that columns have.

    Raises:
        EffectError: an effect of the user's gives no finite motion with any guess.
    """
    asked = [one for e in effects for one in _asked(predictor, adopted, e, guesses[e.name])]
    swinging = [one for one in asked if one.effect.swings]
    others = [one for one in asked if not one.effect.swings]
    free = FreePhases(predictor, sections, rows)
    for one in swinging:
        one.phase = free.phases(one.term, one.of_term(one.settings), residual)
    for section in sections:
        variants = [(one.layout, one.variants) for one in others]
        torques = zip(others, added_torques(predictor, section, adopted, variants), strict=True)
        led = ((one, _swinging(predictor, section, adopted, one)) for one in swinging)
        for one, torque in (*torques, *led):
            one.torque.append(torque.astype(np.float32))
            _check_some_runs(one, torque[:, list(one.rows)].swapaxes(0, 1))
    table = _driven(predictor, sections, asked, residual[rows], rows)
    return _with_base(predictor, sections, adopted, table, rows)


def _swinging(
    predictor: Predictor, section: Section, adopted: tuple[Layout, np.ndarray], one: _Asked
) -> np.ndarray:
    """Torques as of `added_torques`, of each setting with its own phases."""
    settings = np.split(one.variants, len(one.settings))
    return np.concatenate(
        [
            added_torques(
                predictor, with_phase(section, phase, one.new_joints), adopted, [(one.layout, u)]
            )[0]
            for phase, u in zip(one.phase, settings, strict=True)
        ],
        axis=1,
    )


def _check_some_runs(one: _Asked, answers: np.ndarray) -> None:
    """Find an effect of the user's with which nothing can be simulated; (s, …) of its settings."""
    finite = np.isfinite(answers.reshape(len(answers), -1)).all(axis=1)
    if not finite.any() and not shipped(one.effect):
        raise EffectError(
            f"effect {described(one.effect)}: found no finite motion with any of its {len(finite)} "
            "first guesses; allowed: torques and parameters that a simulation can run with"
        )


def settings_of(
    predictor: Predictor,
    adopted: tuple[Layout, np.ndarray],
    effects: Sequence[Effect],
    guesses: Mapping[str, Sequence[Values]],
) -> list[tuple[Layout, np.ndarray]]:
    """Layouts with one effect more, on all joints or on each, and their settings u (s, n)."""
    asked = (one for e in effects for one in _asked(predictor, adopted, e, guesses[e.name]))
    return [(one.layout, one.settings) for one in asked]


def _with_base(predictor, sections, adopted, table: Table, rows: np.ndarray) -> Table:
    """The table with derivatives by what the model has already, and with what it may lose."""
    layout, u = adopted
    free = [i for i, slot in enumerate(layout.slots) if not slot.parameter.rough]
    if not layout.terms:
        return table
    steps = steps_of(layout, free, u)
    moved = np.repeat(u[None], len(free), axis=0)
    moved[np.arange(len(free)), free] += steps
    wanted = Responses(predictor, sections, rows, table.columns.shape[1])
    torques = []
    if free:
        torques = [added_torques(predictor, s, adopted, [(layout, moved)])[0] for s in sections]
    at = [wanted.ask([t[:, k] / steps[k] for t in torques], None) for k in range(len(free))]
    removals = [_removal(term, free, wanted, predictor, sections, adopted) for term in layout.terms]
    columns = np.concatenate([table.columns, wanted.responses()], axis=1)
    return Table(columns, [*table.candidates, *removals], tuple(at), *movable(layout, u, free))


def movable(
    layout: Layout, u: np.ndarray, free: Sequence[int]
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """How far elements `free` of u (n,) may move: `bounds`, `prior` and `tending` of a table."""
    bounds = np.stack([layout.lower[free] - u[free], layout.upper[free] - u[free]], axis=1)
    log = layout.log[free]
    bounds[log] = np.clip(bounds[log], -FARTHEST, FARTHEST)
    return bounds, layout.prior[:, free], -layout.prior @ u


def _removal(
    term: Term,
    free: Sequence[int],
    wanted: "Responses",
    predictor: Predictor,
    sections: Sequence[Section],
    adopted: tuple[Layout, np.ndarray],
) -> Candidate:
    """What the model without a term of its own does."""
    layout, u = adopted
    name = term.effect.name
    rest = Layout([other for other in layout.terms if other is not term])
    values = {slot.key: value for slot, value in zip(layout.slots, u, strict=True)}
    less = rest, np.array([[values[slot.key] for slot in rest.slots]])
    torques = [added_torques(predictor, s, adopted, [less])[0][:, 0] for s in sections]
    own = [i for i, slot in enumerate(layout.slots) if slot.term.effect.name == name]
    fixed = layout.lower >= layout.upper
    without = tuple(k for k, i in enumerate(free) if i in own)
    rough = sum(bool(layout.slots[i].parameter.rough and not fixed[i]) for i in own)
    return Candidate(
        term.effect, term.joints, {}, (wanted.ask(torques, None),), (), len(without) + rough,
        removal=True, without=without,
    )  # fmt: skip


def _asked(
    predictor: Predictor,
    adopted: tuple[Layout, np.ndarray],
    effect: Effect,
    guesses: Sequence[Values],
) -> Iterable[_Asked]:
    """An effect on joints that lack it."""
    layout, u = adopted
    others = [t for t in layout.terms if t.effect.name != effect.name]
    has = {j for t in layout.terms if t.effect.name == effect.name for j in t.joints}
    free = [j for j in effect.places(predictor.joints) if j not in has]
    per_joint = any(p.per_joint for p in effect.parameters)
    if not free or (has and not per_joint):
        return
    apart = per_joint and effect.coupled
    sets = [(j,) for j in free] if apart else [tuple(free)] if free else []
    old = {slot.key: value for slot, value in zip(layout.slots, u, strict=True)}
    for joints in sets:
        term = Term(effect, tuple(sorted({*has, *joints})))
        whole = Layout([*others, term])
        own = [
            i for i, s in enumerate(whole.slots)
            if s.key not in old or (s.term.effect.name == effect.name and s.joint not in has
            and s.joint is not None)
        ]  # fmt: skip
        rows = []
        for guess in guesses:
            own_u = encoded(guess)
            rows.append([old[s.key] if s.key in old else own_u(s) for s in whole.slots])
        settings = np.array(rows, float)
        settings = np.clip(settings, whole.lower, whole.upper)
        # guesses that differ on other joints alone are one here
        settings = np.array(list(dict.fromkeys(map(tuple, settings.tolist()))))
        steps = np.array([steps_of(whole, own, row) for row in settings])
        yield _Asked(effect, term, whole, settings, own, steps, apart)


def encoded(guess: Values) -> Callable[[Slot], float]:
    """u of a slot of an effect, as a guess of its parameters, (njoint,) or (1,), says it."""

    def of(slot: Slot) -> float:
        value = np.ravel(guess[slot.parameter.name])
        number = value[slot.joint] if slot.joint is not None and len(value) > 1 else value[0]
        return np.log(number) if slot.parameter.log else number

    return of


def steps_of(layout: Layout, own: Sequence[int], u: np.ndarray) -> np.ndarray:
    """By how much elements `own` of u (n,) are moved for a derivative."""
    steps = []
    for i in own:
        slot = layout.slots[i]
        size = max(abs(u[i]), slot.size)
        span = layout.upper[i] - layout.lower[i]
        # numerics: of the range, where no size is known
        step = RELATIVE_STEP * (1.0 if slot.parameter.log else size or 1e-3 * span)
        steps.append(-step if u[i] + step > layout.upper[i] else step)
    return np.array(steps)


def _driven(
    predictor: Predictor,
    sections: Sequence[Section],
    asked: Sequence[_Asked],
    residual: np.ndarray,
    rows: np.ndarray,
) -> Table:
    """Candidates of effects that were led along the motion."""
    first = Responses(predictor, sections, rows)
    # what each setting does, on each joint or on all
    places = [
        {
            joint: [first.ask([t[:, row] for t in one.torque], joint) for row in one.rows]
            for joint in [*one.each, *[None] * one.shared]
        }
        for one in asked
    ]
    values = first.responses()
    clearer = _pursued(residual, values)
    second = Responses(predictor, sections, rows, values.shape[1])
    candidates: list[Candidate] = []
    of_joints: dict[str, list[list[Candidate]]] = {}
    for one, at in zip(asked, places, strict=True):
        for joint in one.each:
            own = values[:, at[joint]]
            kept = one.kept(_ranked(residual, own), _ranked(clearer, own))
            made = [_derived(one, s, joint, at[joint][s], second) for s in kept]
            candidates += made
            if made:
                of_joints.setdefault(one.effect.name, []).append(made)
        if one.shared:
            own = values[:, at[None]]
            kept = [*_ranked(residual, own)[:1], *_ranked(clearer, own)[:1]]
            shared = dict.fromkeys(kept)
            candidates += [_derived(one, s, None, at[None][s], second) for s in shared]
    for settings in of_joints.values():
        for k in range(min(KEPT, max(map(len, settings)))):
            if len(settings) > 1:
                candidates.append(_together([made[min(k, len(made) - 1)] for made in settings]))
    return Table(np.concatenate([values, second.responses()], axis=1), candidates)


def _derived(
    one: _Asked, s: int, joint: int | None, constant: int, wanted: "Responses"
) -> Candidate:
    """A candidate at setting s, whose derivatives are asked for."""
    columns, at = [], one.rows[s]
    for g, group in enumerate(one.groups):
        own, as_one = one.of(joint, group), joint is None and one.shared
        for i in own[:1] if as_one else own:
            step, slot, u = one.steps[s, one.own.index(i)], one.layout.slots[i], one.settings[s, i]
            torques = [(t[:, at + 1 + g] - t[:, at]) / step for t in one.torque]
            lower, upper = one.layout.lower[i] - u, one.layout.upper[i] - u
            if slot.parameter.log:
                lower, upper = max(lower, -FARTHEST), min(upper, FARTHEST)
            place = wanted.ask(torques, joint)
            on = None if as_one else slot.joint
            columns.append(Column(place, slot.parameter.name, on, lower, upper))
    joints = (joint,) if joint is not None else tuple(one.new_joints) or one.term.joints
    phases = 0 if one.phase is None else one.phase.shape[1] * len(joints)
    numbers = len(columns) + phases if phases else 0
    setting = one.setting(s, joint)
    return Candidate(one.effect, joints, setting, (constant,), tuple(columns), numbers)


def _ranked(residual: np.ndarray, values: np.ndarray) -> list[int]:
    """Settings, by what their responses (nsample, m) leave of the residual; not what is none."""
    finite, seen, square = _seen(values)
    along = finite.T @ residual
    # numerics: nearer to a setting than to the next
    scale = np.clip(along / np.maximum(square, TINY), 0.3, 3.0)
    left = residual @ residual - 2 * scale * along + scale**2 * square
    left[~seen] = np.inf
    return [int(s) for s in np.argsort(left) if np.isfinite(left[s])]


def _pursued(residual: np.ndarray, values: np.ndarray) -> np.ndarray:
    """What a few of the responses (nsample, m) leave of a residual, the best one after the other.

    Source: Mallat and Zhang, Matching pursuits with time-frequency dictionaries, 1993.
    """
    finite, seen, square = _seen(values)
    for _ in range(PURSUED if seen.any() else 0):
        along = finite.T @ residual
        best = int(np.argmax(np.where(seen, along**2 / np.maximum(square, TINY), 0.0)))
        residual = residual - along[best] / max(square[best], TINY) * finite[:, best]
    return residual


def _seen(values: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Responses (nsample, m), zero where not finite; which are some; their sums of squares."""
    finite = np.isfinite(values)
    values = np.where(finite, values, 0.0)
    square = np.einsum("ij,ij->j", values, values, dtype=float)
    return values, finite.all(axis=0) & (square >= NOWHERE**2 * len(values)), square


def _together(some: Sequence[Candidate]) -> Candidate:
    columns = [c for one in some for c in one.columns]
    return Candidate(
        some[0].effect,
        tuple(sorted(j for one in some for j in one.joints)),
        {k: v for one in some for k, v in one.setting.items()},
        tuple(c for one in some for c in one.constants),
        tuple(columns),
        sum(one.numbers for one in some),
    )


class Responses:
    """Torques that are wanted as responses, all in one pass through the loop."""

    def __init__(
        self,
        predictor: Predictor,
        sections: Sequence[Section],
        rows: np.ndarray,
        first: int = 0,
    ):
        self.sections, self.rows, self.first = sections, rows, first
        self.place = np.full(len(predictor.samples), -1)
        self.place[rows] = np.arange(len(rows))
        self.asked: list[tuple[list[np.ndarray], int | None]] = []

    def ask(self, torques: list[np.ndarray], joint: int | None) -> int:
        """Index of the response to a torque (ntick, nrec, n) in each section; of one joint's."""
        if joint is not None:
            torques = [t[..., joint] for t in torques]
        self.asked.append((torques, joint))
        return self.first + len(self.asked) - 1

    def responses(self) -> np.ndarray:
        """(k, m) at the rows."""
        out = np.empty((len(self.rows), len(self.asked)), np.float32)
        single = [i for i, (_, joint) in enumerate(self.asked) if joint is not None]
        dense = [i for i, (_, joint) in enumerate(self.asked) if joint is None]
        for k, section in enumerate(self.sections):
            place = self.place[section.motion.group.held]
            chosen = np.flatnonzero(place >= 0)
            if single:
                torque = np.stack([self.asked[i][0][k] for i in single], axis=-1)
                joints = np.array([self.asked[i][1] for i in single])
                out[np.ix_(place[chosen], single)] = respond(section, torque, joints, chosen)
            if dense:
                torque = np.stack([self.asked[i][0][k] for i in dense], axis=-1)
                out[np.ix_(place[chosen], dense)] = respond(section, torque, None, chosen)
        return out
