"""A short formula for a learned curve, by symbolic regression (pyoperon), if one fits its band."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from importlib.util import find_spec
from typing import Protocol

import numpy as np

from t2l.effects.law import FRICTION, INERTIA, PHASE, SESSION, TENDON, TORQUE
from t2l.identify.block_bootstrap import improvement
from t2l.identify.levels import NOTHING, PROMISING, TIED
from t2l.propose.band import LEVEL
from t2l.propose.expression import Formula, Node, applied, product, read, total, written
from t2l.propose.proposal import Learned

EXTRA = "propose"  # of pyoperon
SYMBOLS = "add,mul,exp,square,constant,variable"
# a joint turns and a clock may tick; nothing comes again at a higher speed, torque or temperature
REPEATS = {
    (TORQUE, "position"), (TENDON, "position"), (FRICTION, "position"),
    (TORQUE, "time"), (TORQUE, SESSION),
}  # fmt: skip
TIMES = ("time", SESSION)  # over which nothing goes on for ever
MOST_NODES = 16  # tuned: longer is no short formula
EVALUATIONS = 120_000  # numerics: of formulas
SEED = 0  # statistics: of the search, and of the bootstrap
INSIDE = LEVEL  # of the points of a curve that must lie in its band
STRAIGHT = 1e-6  # numerics: change of slope, in parts of the largest values
ALIKE = 1e-3  # numerics: of the constants of a formula that was found twice
SLACK = TIED  # of the largest torque: a smooth curve rounds a kink off by as much


def installed() -> bool:
    """Whether symbolic regression is."""
    return find_spec("pyoperon") is not None and find_spec("sklearn") is not None


@dataclass(frozen=True)
class Fitted:
    """A formula with constants fitted to recordings.

    Attributes:
        error: RMS, rad.
        left_out: (nsample,) rad, what it leaves of each block of time if the others alone fit it.
    """

    formula: Formula
    error: float
    left_out: np.ndarray


class Judge(Protocol):
    """What formulas leave of recordings, also of such that go beyond the curve.

    There formulas within its band may differ much. See `t2l.propose.formula_fit.Simulation`.

    Attributes:
        limit: rad, the most that a formula may leave.
        block: (nsample,) numbers of blocks of time.
    """

    limit: float
    block: np.ndarray

    def errors(self, formulas: Sequence[Formula]) -> list[float]: ...

    def fitted(self, formula: Formula) -> Fitted: ...


def promising(found: Sequence[Formula], judge: Judge) -> list[Fitted]:
    """Those that leave nearly as little as the best, with constants fitted, in their order."""
    begun = judge.errors(found)
    enough = PROMISING * min(begun, default=0.0)
    return [judge.fitted(one) for one, left in zip(found, begun, strict=True) if left <= enough]


def chosen(found: Sequence[Fitted], judge: Judge) -> Formula | None:
    """One of several formulas, from short to long; None if all leave more than the limit.

    The shortest is taken of which no other foretells more, by the paired block bootstrap on blocks
    that were left out.
    """
    near = [one for one in found if one.error <= judge.limit]
    unbeaten = (one for one in near if not any(_beats(other, one, judge.block) for other in near))
    return next((one.formula for one in unbeaten), None)


def _beats(other: Fitted, one: Fitted, block: np.ndarray) -> bool:
    rng = np.random.default_rng(SEED)
    gain = improvement(one.left_out, other.left_out, block, rng)
    return gain.lower > 0 and gain.fraction > NOTHING


def candidates(learned: Learned) -> Iterator[Formula]:
    """Formulas within the band from short to long, with constants fitted to the curve.

    There are none of an inertia.

    Raises:
        ModuleNotFoundError: the extra `propose` is not installed.
    """
    before: list[Formula] = []
    for one in _inside_the_band(learned):
        if not any(_same(one, other) for other in before):
            before.append(one)
            yield one


def _same(one: Formula, other: Formula) -> bool:
    if one.text != other.text:
        return False
    values = ([*each.values.values()] for each in (one, other))
    return np.allclose(*values, rtol=ALIKE, atol=0.0)


def _inside_the_band(learned: Learned) -> Iterator[Formula]:
    curve = learned.curve
    if curve.law.kind == INERTIA:
        return
    x, y = np.array(curve.at), np.array(curve.torque)
    line = Node("sum", 1.0, (Node("x"),))
    # numerics: no band is narrower
    half = np.maximum((learned.high - learned.low) / 2, 1e-3 * np.ptp(y) + 1e-9)

    def fitted(tree: Node) -> Formula:
        found = written(tree, curve.law.unit, share=not curve.law.torque_unit)
        return _fitted(found, x, y, half)

    if curve.law.follows == PHASE:
        wave = written(_wave(x, y), curve.law.unit)
        if _inside(wave, learned, x):
            yield wave
        return
    if curve.law.follows == "constant":
        yield fitted(Node("sum", float(y.mean())))
        return
    scale, height = float(np.abs(x).max()), float(np.abs(y).max())
    simple = (Node("sum", 1.0), Node("product", 2.0, (Node("x"),)), line)
    yield from (found for found in map(fitted, simple) if _inside(found, learned, x))
    if np.ptp(np.diff(y) / np.diff(x)) <= STRAIGHT * height / scale:
        return
    if curve.law.follows in TIMES:
        decays = map(fitted, _decays(x, y, half))
        yield from (found for found in decays if _inside(found, learned, x))
    repeats = (curve.law.kind, curve.law.follows) in REPEATS
    if repeats:
        waves = map(fitted, _waves(x, y, half))
        yield from (found for found in waves if _inside(found, learned, x))
    for tree in _searched(x / scale, y / height, repeats):
        found = fitted(_stretched(tree, scale, height))
        if _inside(found, learned, x):
            yield found


def _wave(x: np.ndarray, y: np.ndarray) -> Node:
    """a sin(b x + c): of the clock, which goes on beyond a period."""
    turn = 2 * np.pi / (x[-1] - x[0])
    sine, cosine = (2 * np.mean((y * f(turn * (x - x[0])))[:-1]) for f in (np.sin, np.cos))
    return _sine(turn, sine, cosine, x[0])


def _waves(x: np.ndarray, y: np.ndarray, half: np.ndarray) -> list[Node]:
    """a sin(b x + c), and with a constant: a search hardly finds many turns.

    The turns are those of the highest peak of a periodogram (Zechmeister and Kürster, The
    generalised Lomb-Scargle periodogram, 2009).
    """
    from scipy.signal import lombscargle

    # numerics: an eighth of a turn over the range apart, up to two points a turn
    turns = np.arange(1, 4 * len(x)) * np.pi / 4 / (x[-1] - x[0])
    weights = (half.min() / half) ** 2
    power = lombscargle(x, y, turns, weights=weights, floating_mean=True, normalize=True)
    turn = turns[np.argmax(power)]
    columns = np.stack([np.sin(turn * x), np.cos(turn * x), np.ones(len(x))], axis=1)
    root = np.sqrt(weights)
    sine, cosine, level = np.linalg.lstsq(columns * root[:, None], y * root, rcond=None)[0]
    wave = _sine(turn, sine, cosine)
    return [wave, total([Node("sum", float(level)), wave])]


def _decays(x: np.ndarray, y: np.ndarray, half: np.ndarray) -> list[Node]:
    """a exp(−b x), and with a constant, to which what warms up or wears in comes.

    Of some rates the one that leaves least (variable projection, Golub and Pereyra, 1973).
    """
    # numerics: from nearly straight to what is over at once
    rates = np.geomspace(0.1, 100.0, 31) / (x[-1] - x[0])
    found = []
    for constant in ([], [np.ones(len(x))]):
        tried = []
        for rate in rates:
            columns = np.stack([np.exp(-rate * x), *constant], axis=1) / half[:, None]
            weights = np.linalg.lstsq(columns, y / half, rcond=None)[0]
            tried.append((np.sum((columns @ weights - y / half) ** 2), rate, weights))
        _, rate, (size, *level) = min(tried, key=lambda one: one[0])
        decay = applied("exp", product([Node("sum", -float(rate)), Node("x")]))
        parts = [Node("sum", float(one)) for one in level]
        found.append(total([*parts, product([Node("sum", float(size)), decay])]))
    return found


def _sine(turn: float, sine: float, cosine: float, begin: float = 0.0) -> Node:
    """`sine` sin(turn (x − begin)) + `cosine` cos(turn (x − begin)) as one sine."""
    phase = (np.arctan2(cosine, sine) - turn * begin) % (2 * np.pi)
    angle = total([Node("sum", float(phase)), product([Node("sum", float(turn)), Node("x")])])
    return product([Node("sum", float(np.hypot(sine, cosine))), applied("sin", angle)])


def extent(formula: Formula, one: Learned) -> tuple[float, float]:
    """Ends of what a formula says in the place of a curve: of one over a phase, its own period."""
    if one.curve.law.follows == PHASE:
        (frequency,) = (v for name, v in formula.values.items() if formula.units[name] == "1/s")
        return one.curve.at[0], one.curve.at[0] + 2 * np.pi / abs(frequency)
    return one.reach


def _searched(x: np.ndarray, y: np.ndarray, repeats: bool) -> Iterator[Node]:
    """Trees from short to long; with sines if what they tell may come again."""
    from pyoperon.sklearn import SymbolicRegressor

    search = SymbolicRegressor(
        allowed_symbols=f"{SYMBOLS},sin" if repeats else SYMBOLS,
        max_length=MOST_NODES, objectives=["mse", "length"],
        # numerics: the evaluations end it first
        population_size=400, generations=60, max_evaluations=EVALUATIONS,
        optimizer_iterations=10, n_threads=1, random_state=SEED,
    )  # fmt: skip
    # of what has one sign the size is nothing new
    columns = [x, np.abs(x)] if (x < 0).any() else [x]
    search.fit(np.stack(columns, axis=1), y)
    for one in sorted(search.pareto_front_, key=lambda one: one["complexity"]):
        try:
            tree = read(one["model"])
        except ValueError:
            continue
        if tree.kind == "sum" and tree.parts:
            # the search always adds a constant
            yield total(list(tree.parts))
        yield tree


def _stretched(tree: Node, scale: float, height: float) -> Node:
    """A tree in x / scale, with values in parts of `height`, as one in x and N·m."""
    return product([Node("sum", height), _in_units(tree, scale)])


def _in_units(tree: Node, scale: float) -> Node:
    if tree.kind in ("x", "abs"):
        return product([Node("sum", 1 / scale), tree])
    parts = [_in_units(part, scale) for part in tree.parts]
    if tree.kind == "sum":
        return total([Node("sum", tree.value), *parts])
    if tree.kind == "product":
        return product([Node("sum", tree.value), *parts])
    return applied(tree.kind, parts[0])


def _fitted(formula: Formula, x: np.ndarray, y: np.ndarray, half: np.ndarray) -> Formula:
    """The formula with constants fitted to the curve, in units of its band."""
    from scipy.optimize import least_squares

    names = list(formula.values)

    def off(values: np.ndarray) -> np.ndarray:
        with np.errstate(over="ignore", invalid="ignore"):
            left = (formula(x, dict(zip(names, values, strict=True))) - y) / half
        return np.nan_to_num(left, nan=1e6, posinf=1e6, neginf=-1e6)  # numerics: worse than any

    start = np.array(list(formula.values.values()))
    # numerics: it settles before
    best = least_squares(off, start, x_scale=np.abs(start) + 1e-9, max_nfev=200)
    found = dict(zip(names, best.x.tolist(), strict=True))
    return Formula(formula.text, found, formula.units)


def _inside(formula: Formula, learned: Learned, x: np.ndarray) -> bool:
    value, slack = formula(x), SLACK * np.abs(learned.curve.torque).max()
    inside = (learned.low - slack <= value) & (value <= learned.high + slack)
    return bool(inside.mean() >= INSIDE)
