"""Linearise, screen, fit, judge, and again from what was adopted, until nothing earns its place."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from t2l.detective.candidates import known_candidates
from t2l.detective.certainty import chosen_shares
from t2l.detective.data_split import DataSplit
from t2l.detective.fit import FittedSet, Samples, Start, begun, finish, fit_sets, refine
from t2l.detective.linear_loop import linearised
from t2l.detective.motion import measured_motion
from t2l.detective.rule import Judge
from t2l.detective.screen import Scored, Screen
from t2l.diagnose.starting_points import read_off
from t2l.effects.term import Layout, Term
from t2l.identify.block_bootstrap import blocks
from t2l.identify.first_guesses import first_guesses
from t2l.identify.levels import PROMISING
from t2l.identify.model import Model, from_vector
from t2l.identify.noise_floor import noise_floor
from t2l.identify.prediction import Request, check_finite
from t2l.identify.scales import scales

ROUNDS = 6  # bound: of a search: more is a model that fits anything
FITTED = 10  # numerics: sets of a round that are fitted in full
FINISHED = 4  # numerics: of these, on every tick
# what a round does, in turn
STAGES = SCREEN, FIT, FINISH, PRUNE = "screening", "fitting", "finishing", "pruning"

# effects with the joints that have them
Named = Iterable[tuple[str, tuple[int, ...]]]


@dataclass
class Round:
    """What was looked at from one model, and what was adopted.

    Attributes:
        before: the model that it began with.
        front: sets of the screen: how many numbers, the promised error in rad, and the effects
            with the joints that have them.
        fits: sets that were fitted, best first.
        adopted: what became of it; None if nothing earned its place.
        shares: of the effects that were added, how often resamples choose them.
        doing: what comes next, of `STAGES`; "" at the end.
    """

    before: FittedSet
    noise_rad: float
    front: list[tuple[int, float, list[tuple[str, tuple[int, ...]]]]] = field(default_factory=list)
    fits: list[FittedSet] = field(default_factory=list)
    adopted: FittedSet | None = None
    shares: dict[str, float] = field(default_factory=dict)
    doing: str = ""

    @property
    def added(self) -> dict[str, tuple[int, ...]]:
        """Effects of what was adopted, with the joints that did not have them before."""
        return more_than(self.before.names, self.adopted.names) if self.adopted else {}


@dataclass
class Found:
    """The final model and the rounds that led to it; whether the time was over before the end."""

    model: Model
    rounds: list[Round] = field(default_factory=list)
    stopped: bool = False


def search(
    model: Model,
    data: DataSplit,
    looked: Callable[["Round"], None] = lambda this: None,
    over: Callable[[], bool] = lambda: False,
    resumed: tuple[int, FittedSet] | None = None,
) -> Found:
    """What `model` lacks.

    Args:
        looked: told of each round before each of its `STAGES`, and when it adopted something.
        over: whether the time is; asked between fits.
        resumed: rounds that are done, and what they adopted.

    Raises:
        DivergenceError: the simulation of the model runs away.
    """
    predictor, mask = data.fitted, data.fitted_mask
    joints, samples = predictor.joints, predictor.samples
    block = blocks(samples.recording[mask], samples.time[mask])
    whole = Samples(predictor, predictor, mask, data.folds)
    layout, u = model.vector(joints)
    request = Request(layout, u[None])
    check_finite(predictor.predict([request])[0][0], predictor, request)
    done, current = resumed or (0, *fit_sets([Start(layout, u)], whole, iterations=0))
    found = Found(model)

    def stop(this: Round, doing: str) -> bool:
        this.doing = doing
        found.stopped = over()
        if not found.stopped:
            looked(this)
        return found.stopped

    for _ in range(done, ROUNDS):
        left = np.full(len(samples), np.nan)
        left[mask] = -current.residual
        judge = Judge(block, noise_floor(list(predictor.recordings), samples.by_row(left)))
        this = Round(current, judge.noise_rad)
        found.rounds.append(this)
        if judge.quiet(current.left_out_rmse) or stop(this, SCREEN):
            break
        adopted = current.layout, current.u
        fitted = Samples.of(predictor, mask, data.folds, adopted, judge.noise_rad)
        screen = _screen(model, fitted, adopted, np.nan_to_num(left))
        sets = _worth_fitting(screen)
        this.front = [
            (
                one.parameters, float(np.sqrt(one.error)),
                [candidate.key for candidate in screen.chosen(one.members)],
            )
            for one in sets
        ]  # fmt: skip
        if stop(this, FIT):
            break
        starts = [begun(adopted, screen, s.members) for s in sets]
        known = adopted, current.residual
        fits = fit_sets(starts, fitted, known)
        this.fits = sorted(fits, key=lambda f: f.left_out_rmse)
        if stop(this, FINISH):
            break
        fits = finish(refine(_leaders(fits, judge), fitted, known), fitted)
        this.fits = sorted(fits, key=lambda f: f.left_out_rmse)
        better = choose(current, fits, judge)
        if better is None:
            break
        this.doing = PRUNE
        looked(this)
        current = this.adopted = prune(better, fitted, judge)
        this.shares = chosen_shares(screen, this.added)
        this.doing = ""
        looked(this)
    found.model = from_vector(model, current.layout, current.u, joints)
    return found


def more_than(before: Named, after: Named) -> dict[str, tuple[int, ...]]:
    """Effects of `after` by name, with the joints that do not have them in `before`."""
    had = dict(before)
    new = {name: set(on) - set(had.get(name, ())) for name, on in sorted(dict(after).items())}
    return {name: tuple(sorted(on)) for name, on in new.items() if on}


def choose(current: FittedSet, fits: Sequence[FittedSet], judge: Judge) -> FittedSet | None:
    """The set that the rule takes: of those alike with the best that of fewest parameters."""
    earning = [f for f in fits if judge.earns(current.left_out, f.left_out)]
    if not earning:
        return None
    best = min(f.left_out_rmse for f in earning)
    alike = [f for f in earning if judge.alike(f.left_out_rmse, best)]
    return min(alike, key=lambda f: (f.parameters, f.left_out_rmse))


def _leaders(fits: Sequence[FittedSet], judge: Judge) -> list[FittedSet]:
    """Of those fitted at fewer ticks what may be taken: the best, and others of few numbers."""
    ranked = sorted(fits, key=lambda f: f.left_out_rmse)
    if not ranked:
        return []
    chosen = ranked[:1]
    limit = max(PROMISING * ranked[0].left_out_rmse, 2 * judge.noise_rad)
    near = [f for f in ranked if f.left_out_rmse <= limit]
    for one in sorted(near, key=lambda f: (f.parameters, f.left_out_rmse)):
        if one not in chosen and len(chosen) < FINISHED:
            chosen.append(one)
    return chosen


def prune(better: FittedSet, samples: Samples, judge: Judge) -> FittedSet:
    """Drop terms, joint by joint, that the rule does not miss."""
    while True:
        trials = _without_one(better)
        if not trials:
            return better
        known = (better.layout, better.u), better.residual
        fits = fit_sets(trials, samples, known, iterations=3)
        kept = [f for f in fits if not judge.earns(f.left_out, better.left_out)]
        kept = finish(sorted(kept, key=lambda f: f.left_out_rmse)[:2], samples)
        kept = [f for f in kept if not judge.earns(f.left_out, better.left_out)]
        if not kept:
            return better
        better = min(kept, key=lambda f: f.left_out_rmse)


def _without_one(whole: FittedSet) -> list[Start]:
    old = {s.key: v for s, v in zip(whole.layout.slots, whole.u, strict=True)}
    known, trials = whole.columns, []
    for term in whole.layout.terms:
        others = [t for t in whole.layout.terms if t is not term]
        fewer = [tuple(j for j in term.joints if j != gone) for gone in term.joints]
        if not any(p.per_joint for p in term.effect.parameters) or len(term.joints) == 1:
            fewer = [()]
        for joints in fewer:
            layout = Layout([*others, Term(term.effect, joints)] if joints else others)
            if layout.terms:
                u = np.array([old[s.key] for s in layout.slots])
                columns = {s.key: known[s.key] for s in layout.slots if s.key in known}
                trials.append(Start(layout, u, columns))
    return trials


def _worth_fitting(screen: Screen) -> list[Scored]:
    """The front, what is nearly on it, and the best single candidates."""
    front = [s for s in screen.search() if s.members]
    known = sorted((s for s in screen.known.values() if s.members), key=lambda s: s.error)
    singles = [s for s in known if len(s.members) == 1]
    chosen: list[Scored] = []
    names: list[set[tuple[str, tuple[int, ...]]]] = []
    for one in [*front[: FITTED // 2], *singles[:4], *known[:2]]:
        keys = {candidate.key for candidate in screen.chosen(one.members)}
        if keys not in names:
            chosen.append(one)
            names.append(keys)
    return chosen[:FITTED]


def _screen(
    model: Model, samples: Samples, adopted: tuple[Layout, np.ndarray], residual: np.ndarray
) -> Screen:
    predictor, mask = samples.draft, samples.mask
    layout, u = adopted
    sections = linearised(predictor, layout, u, measured_motion(predictor, layout, u))
    sizes, n = scales(predictor), len(predictor.joints)
    effects = [
        e for e in model.known_effects(predictor.joints).values()
        if e.may_act(predictor.recordings)
    ]  # fmt: skip
    read = read_off(predictor, mask, effects, residual)
    guesses = {e.name: first_guesses(e, sizes, n) + read[e.name] for e in effects}
    table = known_candidates(
        predictor, samples.draft, sections, adopted, effects, guesses, residual
    )
    table = replace(table, columns=table.columns[mask])
    return Screen(table, residual[mask], samples.folds)
