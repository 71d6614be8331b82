"""Linearise, screen, fit, judge, and again from what was adopted, until nothing earns its place."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import product

import numpy as np

from t2l.detective.along_motion import AlongMotion, fit_along
from t2l.detective.candidates import Values, known_candidates
from t2l.detective.certainty import chosen_shares
from t2l.detective.choosing import (
    ASTRAY,
    astray,
    choose,
    exchanged,
    exchanges,
    leaders,
    nearest,
    worth_fitting,
)
from t2l.detective.curves import curves, with_curves
from t2l.detective.data_split import DataSplit
from t2l.detective.fit import Samples, begun, finish, fit_sets
from t2l.detective.fitted_set import FittedSet, Known, Start
from t2l.detective.forward import LITTLE, growing, of_each_size
from t2l.detective.linear_loop import linearised
from t2l.detective.motion import measured_motion
from t2l.detective.pruning import pruned, pruned_along
from t2l.detective.rule import Judge
from t2l.detective.screen import Scored, Screen
from t2l.detective.second_guesses import second_guesses
from t2l.detective.starting_points import read_off
from t2l.effects.effect import Effect
from t2l.identify.block_bootstrap import blocks
from t2l.identify.first_guesses import first_guesses
from t2l.identify.levels import HALF, NOTHING
from t2l.identify.model import Model, from_vector
from t2l.identify.noise_floor import noise_floor
from t2l.identify.prediction import Request, check_finite
from t2l.identify.progress import Progress
from t2l.identify.scales import sized
from t2l.propose.proposal import Ceiling

ROUNDS = 6  # bound: of a search: more is a model that fits anything
SCREENED = 8000  # numerics: samples that sets are scored by
ALONE = 12  # numerics: effects alone that are simulated to rank them
# numerics: sets that are simulated as they are: of the screen, of those that grew, of a step
FOLLOWED, GROWN, CHECKED = 30, 6, 2
NEARER = 0.5  # numerics: of the error of the model of which the loop is linearised, to do it again
# what a round does, in turn
STAGES = SCREEN, FIT, FINISH, GROW, PRUNE = (
    "screening",
    "fitting",
    "finishing",
    "growing",
    "pruning",
)
# format: of a round, what is done when a stage begins, as measured
DONE = {SCREEN: 0.0, FIT: 0.2, FINISH: 0.3, GROW: 0.3, PRUNE: 0.8}

# effects with the joints that have them
Named = Iterable[tuple[str, tuple[int, ...]]]


@dataclass
class Round:
    """What was looked at from one model, and what was adopted.

    Attributes:
        before: the model that it began with.
        front: sets of the screen: how many numbers, the promised error in rad, and the effects
            with the joints that have them.
        led: sets that were fitted along the measured motion.
        likely: the best set along the measured motion; None if it does not earn its place.
        grown: the best set after each step of growing, along the motion.
        fits: sets that were fitted by simulation, best first.
        adopted: what became of it; None if nothing earned its place by simulation.
        promised: what only the linear model promises, from which the next round goes on.
        ties: sets that explain as well as the model after it, by simulation, see `Judge.ties`.
        shares: of the effects that were added, how often resamples choose them.
        effects: that were offered, by name; ceilings: what each law alone promises.
        quiet: whether only noise is left, so that it looks for exchanges alone.
        doing: what comes next, of `STAGES`; "" when it adopted something.
    """

    before: FittedSet
    noise_rad: float
    front: list[tuple[int, float, list[tuple[str, tuple[int, ...]]]]] = field(default_factory=list)
    led: list[FittedSet] = field(default_factory=list)
    likely: FittedSet | None = None
    grown: list[FittedSet] = field(default_factory=list)
    fits: list[FittedSet] = field(default_factory=list)
    adopted: FittedSet | None = None
    promised: FittedSet | None = None
    ties: list[FittedSet] = field(default_factory=list)
    shares: dict[str, float] = field(default_factory=dict)
    effects: dict[str, Effect] = field(default_factory=dict)
    ceilings: list[Ceiling] = field(default_factory=list)
    quiet: bool = False
    doing: str = ""

    @property
    def added(self) -> dict[str, tuple[int, ...]]:
        """Effects of what was adopted, with the joints that did not have them before."""
        return more_than(self.before.names, self.adopted.names) if self.adopted else {}


@dataclass
class Found:
    """What the rounds led to.

    Attributes:
        last: the final model as it was fitted.
        stopped: whether the time was over before the end.
    """

    model: Model
    rounds: list[Round] = field(default_factory=list)
    last: FittedSet | None = None
    stopped: bool = False


@dataclass(frozen=True)
class Offered:
    """What may be missing: known effects by their names, and curves over one variable."""

    names: bool = True
    curves: bool = True


def search(
    model: Model,
    data: DataSplit,
    looked: Callable[["Round"], None] = lambda this: None,
    spent: Callable[[], float] = lambda: 0.0,
    resumed: tuple[int, FittedSet] | None = None,
    offered: Offered = Offered(),
) -> Found:
    """What `model` lacks.

    Args:
        looked: told of each round before each of its `STAGES`, as its sets grow, and when it
            adopted something.
        spent: share of the time that is gone, asked between fits: at 1 nothing new begins.
        resumed: rounds that are done, and what they adopted.

    Raises:
        DivergenceError: the simulation of the model runs away.
    """
    searched = _Search(sized(model, data.fitted), data, looked, spent, offered)
    done = searched.begin(resumed)
    for number in range(done, ROUNDS):
        if not searched.round(came=number == 0):
            break
    if not searched.found.rounds:
        # resumed when all rounds were done
        searched.found.rounds.append(Round(searched.simulated, searched.noise_rad()))
    return searched.found


@dataclass(frozen=True)
class Singles:
    """Known effects, each fitted alone beside the model as it came.

    Attributes:
        along: by the linear model of the loop; `simulated`: those that promise most.
    """

    came: FittedSet
    along: list[FittedSet]
    simulated: list[FittedSet]
    judge: Judge


def singles(
    model: Model, data: DataSplit, progress: Progress = lambda what, fraction: None
) -> Singles:
    """Each known effect where it explains most: on one joint or on all.

    Raises:
        DivergenceError: the simulation of the model runs away.
    """
    nothing = lambda *_: None  # noqa: E731
    searched = _Search(model, data, nothing, lambda: 0.0, Offered(curves=False))
    searched.begin(None)
    return searched.singles(progress)


class _Search:
    """The rounds so far.

    Attributes:
        simulated: what was adopted last.
        current: the same along the measured motion, or what the linear model promises beyond it.
        linearised_rmse: rad, what the model of which the loop is linearised leaves by simulation.
        nearest_rmse: likewise of the last one at which that was tried.
    """

    def __init__(self, model: Model, data: DataSplit, looked, spent, offered: Offered):
        self.model, self.data, self.looked, self.spent = model, data, looked, spent
        self.offered = offered
        predictor, mask = data.fitted, data.fitted_mask
        samples = predictor.samples
        self.block = blocks(samples.recording[mask], samples.time[mask])
        self.found = Found(model)
        self.along: AlongMotion | None = None
        # whether exchanges for what was adopted last were looked at
        self.settled = True
        self.ceilings: list[Ceiling] = []

    def begin(self, resumed: tuple[int, FittedSet] | None) -> int:
        """How many rounds are done."""
        predictor, data = self.data.fitted, self.data
        whole = Samples(predictor, predictor, predictor, data.fitted_mask, data.folds)
        layout, u = self.model.vector(predictor.joints)
        request = Request(layout, u[None])
        check_finite(predictor.predict([request])[0][0], predictor, request)
        self.settled = resumed is None
        done, simulated = resumed or (0, *fit_sets([Start(layout, u)], whole, iterations=0))
        self.current = simulated
        self._take(simulated)
        return done

    def _take(self, simulated: FittedSet) -> None:
        self.simulated = simulated
        joints = self.data.fitted.joints
        self.found.model = from_vector(self.model, *simulated.model, joints)
        self.found.last = simulated

    def over(self) -> bool:
        """Whether no new work is to begin."""
        return self.spent() >= 1

    def _stop(self, this: Round, doing: str) -> bool:
        this.doing = doing
        self.found.stopped = self.over()
        if not self.found.stopped:
            self.looked(this)
        return self.found.stopped

    def round(self, came: bool) -> bool:
        """Whether the search goes on after one more.

        Args:
            came: whether the model is as it came.
        """
        noise_rad = self.noise_rad()
        judge = Judge(self.block, noise_rad)
        this = Round(self.simulated, noise_rad)
        self.found.rounds.append(this)
        quiet = this.quiet = judge.quiet(self.simulated.rmse, came)
        if (quiet and self.settled) or self._stop(this, SCREEN):
            return False
        if self.along is None:
            self._linearise(noise_rad, self.simulated.known, self.simulated.rmse)
        left, guesses = self._left(self.current), self._guesses(self.current)
        screen = self._screen(left, *guesses, may_bend=not quiet)
        starts = self._screened(this, screen)
        along, folds = self.along, self.data.folds
        this.led = fit_along(starts, along, folds, racing=True)
        promised = choose(self.current, this.led, judge)
        if not quiet:
            this.likely = promised
        if self._stop(this, FIT):
            return False
        if quiet:
            some = exchanged(self.current, this.led, judge, self.simulated.complexity + 1)
        else:
            some = leaders(self.current, [one for one, _ in self._followed(this.led)], judge)
        better = self._simulated(this, some, judge)
        # what little is left beside noise is for the next round, effect by effect
        little = better is not None and better.rmse <= LITTLE * noise_rad
        if not (quiet or little or self.found.stopped or self._stop(this, GROW)):
            new = self._grown(this, screen, judge)
            this.likely = promised = choose(self.current, this.led, judge)
            better = self._simulated(this, leaders(self.current, new, judge), judge)
        if self.found.stopped and better is None:
            return False
        lost = promised is not None and astray(self.simulated, promised, judge)
        if better is None and not lost:
            this.ties = [f for f in this.fits if judge.ties(self.simulated, f)]
            return False
        this.doing = PRUNE
        self.looked(this)
        if better is not None:
            return self._adopt(this, better, judge) and not quiet
        self.current = this.promised = pruned_along(promised, self.along, judge, folds, self.over)
        return bool(more_than(self.simulated.names, this.promised.names)) and not quiet

    def _screened(self, this: Round, screen: Screen) -> list[Start]:
        """Where the fits of a round begin."""
        this.effects = {c.effect.name: c.effect for c in screen.table.candidates}
        this.ceilings = self.ceilings
        sets = exchanges(screen) if this.quiet else worth_fitting(screen)
        this.front = [
            (
                one.complexity, float(np.sqrt(one.error)),
                [c.key for c in screen.chosen(one.members) if not c.removal],
            )
            for one in sets
        ]  # fmt: skip
        return [begun(self.current.model, screen, one.members) for one in sets]

    def _grown(self, this: Round, screen: Screen, judge: Judge) -> list[FittedSet]:
        """Let the sets of a round grow along the motion.

        The loop is linearised again at what they lead to, as soon as that is much nearer: there
        the linear model is off by less, and what is missing still is read off a clearer residual.

        Returns:
            The new ones that a simulation follows.
        """
        folds, before = self.data.folds, this.led
        # what has grown is simulated, pruned, and grows on from there
        until = HALF * (1 + self.spent())
        screen = self._again_at(this, [(f, f.rmse) for f in this.fits], judge) or screen
        again: Screen | None = screen
        while again is not None:
            screen, again = again, None
            steps = growing(
                self.current, this.led, screen, self.rows, self.along, folds, judge,
                self.linearised_rmse,
            )  # fmt: skip
            for this.led, best in steps:
                this.grown.append(best)
                self.looked(this)
                if self.spent() >= until:
                    break
                if best.left_out_rmse <= NEARER * self.nearest_rmse:
                    again = self._again_at(this, self._followed(this.led, CHECKED), judge)
                    if again is not None:
                        break
        followed = self._followed(this.led, GROWN)
        new = [one for one, _ in followed if all(one is not old for old in before)]
        if new and not self.over():
            # what is not needed takes time in every simulation
            best = min(new, key=lambda f: f.left_out_rmse)
            fewer = pruned_along(best, self.along, judge, folds, self.over)
            if fewer is not best:
                new.append(fewer)
                this.led.append(fewer)
        return new

    def _again_at(
        self, this: Round, simulated: Sequence[tuple[FittedSet, float]], judge: Judge
    ) -> Screen | None:
        """Linearise at the best of some sets, if that is much nearer, and true to its simulation.

        Args:
            simulated: with what the simulation of each leaves, rad.

        Returns:
            The screen there; the sets that may grow are fitted again.
        """
        one, rmse = min(simulated, key=lambda pair: pair[1], default=(None, np.inf))
        if rmse > NEARER * self.nearest_rmse or judge.quiet(rmse):
            return None
        before = self.samples, self.sections, self.along, self.current, self.linearised_rmse
        self._linearise(this.noise_rad, one.known, rmse)
        if self.along.rmse > ASTRAY * rmse:
            self.samples, self.sections, self.along, self.current, self.linearised_rmse = before
            return None
        carried = {frozenset(f.names): Start(f.layout, f.u) for f in (*of_each_size(this.led), one)}
        this.led = fit_along([*carried.values()], self.along, self.data.folds)
        clearer = min(this.led, key=lambda f: f.left_out_rmse, default=self.current)
        guesses, still = self._guesses(clearer), self._left(clearer)
        return self._screen(self._left(self.current), *guesses, may_bend=False, still=still)

    def _followed(
        self, led: Sequence[FittedSet], most: int = FOLLOWED
    ) -> list[tuple[FittedSet, float]]:
        """Of the best along the motion those that a simulation with their numbers follows best.

        Returns:
            With what the simulation leaves, rad.
        """
        some = sorted(led, key=lambda f: f.left_out_rmse)[:most]
        predictor, mask = self.samples.linear, self.samples.mask
        simulated = predictor.predict([Request(f.layout, f.u[None]) for f in some])
        measured = predictor.samples.q[mask]
        left = (np.nan_to_num(q[0, mask], nan=np.inf) - measured for q in simulated)
        errors = [float(np.sqrt(np.mean(one**2))) for one in left]
        limit = ASTRAY * min(errors, default=np.inf)
        return [(f, error) for f, error in zip(some, errors, strict=True) if error <= limit]

    def _simulated(self, this: Round, some: Sequence[FittedSet], judge: Judge) -> FittedSet | None:
        """What the rule takes of all sets that were fitted by simulation, with these.

        Args:
            some: fitted along the motion.
        """
        begins = [Start(f.layout, f.u, f.columns) for f in some]
        if begins or not this.quiet:
            best = min(some or this.led, key=lambda f: f.left_out_rmse, default=self.simulated)
            self.samples = self.samples.drafted(best.model, best.left_out_rmse)
        samples, known, before = self.samples, self.simulated.known, this.fits
        fits = fit_sets(begins, samples, self.along, known)
        this.fits = sorted([*before, *fits], key=lambda f: f.left_out_rmse)
        if not self._stop(this, FINISH):
            fits = finish(nearest(fits, judge), samples, self.along)
            this.fits = sorted([*before, *fits], key=lambda f: f.left_out_rmse)
        return choose(self.simulated, this.fits, judge)

    def _read_anew(self, fit: FittedSet, judge: Judge) -> FittedSet:
        """It, or the same set from second guesses where these lead to surely less."""
        along, folds = self.along, self.data.folds
        while not (judge.quiet(fit.rmse) or self.over()):
            led = fit_along([Start(fit.layout, fit.u)], along, folds, 0)
            likely = choose(led[0], second_guesses(fit, along, folds), judge) if led else None
            if likely is None:
                break
            start = Start(likely.layout, likely.u, likely.columns)
            fits = fit_sets([start], self.samples, along, self.simulated.known)
            better = choose(fit, finish(fits, self.samples, along), judge)
            if better is None:
                break
            fit = better
        return fit

    def _adopt(self, this: Round, better: FittedSet, judge: Judge) -> bool:
        """Whether something is adopted: not what has the same effects again and is no better."""
        better = self._read_anew(better, judge)
        adopted = pruned(better, self.samples, judge, self.along, self.simulated, self.over)
        same = adopted.names == this.before.names
        if same and adopted.rmse > (1 - NOTHING) * this.before.rmse:
            this.ties = [f for f in this.fits if judge.ties(self.simulated, f)]
            return False
        this.adopted = adopted
        self._take(adopted)
        fits = [this.before, *this.fits, adopted]
        this.shares = chosen_shares(fits, self.data.folds, this.added)
        this.ties = [f for f in this.fits if judge.ties(adopted, f)]
        self.current, self.along, self.settled = adopted, None, False
        this.doing = ""
        self.looked(this)
        return True

    def _left(self, model: FittedSet) -> np.ndarray:
        """Measured minus predicted (nsample,), zero where nothing is fitted."""
        left = np.zeros(len(self.data.fitted.samples))
        left[self.data.fitted_mask] = -model.residual
        return left

    def noise_rad(self) -> float:
        """Of the samples, by what the present model leaves."""
        predictor, mask = self.data.fitted, self.data.fitted_mask
        left = np.where(mask, self._left(self.simulated), np.nan)
        return noise_floor(list(predictor.recordings), predictor.samples.by_row(left))

    def _linearise(self, noise_rad: float, known: Known, rmse_rad: float) -> None:
        """Along the motion, at a model of which `rmse_rad` is the error by simulation.

        What remembers has no derivative, so the loop may run away without it: then its feedback is
        that of the model as it came. Or small errors of the measured motion may move a stiff loop
        much: where all that leaves far more than the simulation, the motion is the simulated one.
        """
        data, model = self.data, known[0]
        self.linearised_rmse = self.nearest_rmse = rmse_rad
        self.samples = Samples.of(data.fitted, data.fitted_mask, data.folds, model, noise_rad)
        linear = self.samples.linear
        measured, came = measured_motion(linear, *model), self.model.vector(linear.joints)
        foretold = [one.foretold() for one in measured]
        tried = []
        for motions, feedback in product((measured, foretold), (model, came)):
            sections = linearised(linear, *model, motions, feedback)
            along = AlongMotion(linear, sections, data.fitted_mask, known, noise_rad)
            tried.append((np.nan_to_num(along.rmse, nan=np.inf), sections, along))
            if along.rmse <= ASTRAY * max(rmse_rad, noise_rad):
                break
        _, self.sections, self.along = min(tried, key=lambda one: one[0])
        start = Start(*self.current.model)
        self.current = next(iter(fit_along([start], self.along, data.folds, 0)), self.current)

    def _guesses(self, beside: FittedSet) -> tuple[list[Effect], dict[str, list[Values]]]:
        """Effects that may act, and by name the settings where they are tried beside a model."""
        if not self.offered.names:
            return [], {}
        predictor = self.samples.linear
        effects = [
            e for e in self.model.known_effects(predictor.joints).values()
            if e.may_act(predictor.recordings)
        ]  # fmt: skip
        base = self.along.base
        read = read_off(predictor, self.sections, self.samples.mask, base, beside.model, effects)
        n = len(predictor.joints)
        return effects, {
            e.name: first_guesses(e, self.model.sizes, n) + read[e.name] for e in effects
        }

    def _screen(
        self,
        left: np.ndarray,
        effects: Sequence[Effect],
        guesses: Mapping[str, Sequence[Values]],
        may_bend: bool = True,
        still: np.ndarray | None = None,
    ) -> Screen:
        """Candidates, scored at some of the samples.

        Args:
            left: (nsample,) what the current model leaves, rad.
            still: likewise another, which says what settings of an effect promise most.
        """
        predictor, mask = self.samples.linear, self.samples.mask
        every = -(-int(mask.sum()) // SCREENED)
        joint = predictor.samples.joint[mask]
        of_joints = (np.flatnonzero(joint == j)[::every] for j in range(len(predictor.joints)))
        some = np.sort(np.concatenate(list(of_joints)))
        rows, folds = np.flatnonzero(mask)[some], self.samples.folds[some]
        self.rows = some
        adopted, noise = self.current.model, self.samples.noise_rad
        sizes, finest = self.model.sizes, []
        if self.offered.curves and may_bend:
            reported = self.data.test.recordings
            finest = curves(predictor, adopted, left, sizes, self.offered.names, reported)
            # a law that is not zero where its weights are is tried at settings, as an effect
            begun_at = [e for e in finest if e.atoms is not None]
            effects = [*effects, *begun_at]
            guesses = {**guesses, **{e.name: e.starts(sizes) for e in begun_at}}
            finest = [e for e in finest if e.atoms is None]
        still = left if still is None else still
        table = known_candidates(predictor, self.sections, adopted, effects, guesses, still, rows)
        if finest:
            table, self.ceilings = with_curves(
                table, predictor, self.sections, adopted, finest, noise, left[rows], folds, rows,
                self.offered.names,
            )  # fmt: skip
        return Screen(table, left[rows], folds, noise)

    def singles(self, progress: Progress) -> "Singles":
        """Known effects, each fitted alone, see `singles`."""
        noise_rad = self.noise_rad()
        judge, came = Judge(self.block, noise_rad), self.simulated
        progress("screening known effects in the linear model", 0.0)
        self._linearise(noise_rad, came.known, came.rmse)
        left = self._left(self.current)
        screen = self._screen(left, *self._guesses(self.current))
        best: dict[str, Scored] = {}
        for i, candidate in enumerate(screen.table.candidates):
            if candidate.removal:
                continue
            scored, name = screen.score((i,)), candidate.effect.name
            if name not in best or scored.error < best[name].error:
                best[name] = scored
        progress(f"fitting {len(best)} effects along the measured motion", DONE[FIT])
        starts = [begun(came.model, screen, one.members) for one in best.values()]
        led = fit_along(starts, self.along, self.data.folds)
        led.sort(key=lambda fit: fit.left_out_rmse)
        leaders = [Start(f.layout, f.u, f.columns) for f in led[:ALONE]]
        progress(f"simulating {len(leaders)} of them", DONE[FINISH])
        fits = fit_sets(leaders, self.samples, self.along, came.known)
        fits = finish(fits, self.samples, self.along)
        return Singles(came, led, self._found_again(fits, led, judge), judge)

    def _found_again(
        self, fits: Sequence[FittedSet], led: Sequence[FittedSet], judge: Judge
    ) -> list[FittedSet]:
        """Fits, of which those that are lost begin anew where they were led to, on every tick."""
        promised = {frozenset(one.names): one for one in led}
        pairs = ((promised.get(frozenset(fit.names)), fit) for fit in fits)
        lost = [one for one, fit in pairs if one is not None and astray(fit, one, judge)]
        whole = replace(self.samples, draft=self.samples.exact)
        again = fit_sets([Start(f.layout, f.u) for f in lost], whole)
        best: dict[frozenset, FittedSet] = {}
        for fit in sorted((*fits, *again), key=lambda f: f.left_out_rmse):
            best.setdefault(frozenset(fit.names), fit)
        return list(best.values())


def more_than(before: Named, after: Named) -> dict[str, tuple[int, ...]]:
    """Effects of `after` by name, with the joints that do not have them in `before`."""
    had = dict(before)
    new = {name: set(on) - set(had.get(name, ())) for name, on in sorted(dict(after).items())}
    return {name: tuple(sorted(on)) for name, on in new.items() if on}
