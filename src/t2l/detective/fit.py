"""Sets of candidates fitted in full simulation, from where the linear model leads."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from t2l.detective.candidates import FARTHEST
from t2l.detective.linear_loop import Section, respond
from t2l.detective.motion import at_samples
from t2l.detective.responses import added_torques, excess, stiffness
from t2l.detective.screen import ALIKE, Screen, bounded, independent
from t2l.effects.term import Layout, Term
from t2l.identify.fitting import PositionError as Positions
from t2l.identify.least_squares import LeastSquares
from t2l.identify.levels import HALF, MATERIAL
from t2l.identify.optimiser import Objective, Optimiser, minimise
from t2l.identify.prediction import Predictor, Request

ITERATIONS = 5  # numerics: of a fit with the derivatives of the linear model
REFINING = 1  # numerics: more, with derivatives by simulation
# numerics: of the logarithm of what has no derivative, one after the other
ROUGH_STEPS = (0.3, 0.15, 0.08, 0.04, 0.02)
ROUGH_ITERATIONS = 2  # numerics: of the others meanwhile
FINISHING = 3  # numerics: on every tick, with the derivatives of coarser ones
NEAR_ITS_END = 1e-3  # numerics: damping of a fit that begins there
RIDGE = 1e-6  # numerics: of a column's sum of squares
DAMPINGS = (RIDGE, 0.01, 1.0)  # numerics: likewise, of steps to what fits without a part
LONGER = 1.0  # numerics: samples' worth of squared error, by which a step may be too long
TINY = 1e-300  # numerics: of a column that does nothing
COARSENESS = (40, 20, 10, 5, 4, 2)  # numerics: control periods a tick that are tried
COARSEST = 5  # numerics: of a loop with periods that are not short
LONG_TICK_S = 1e-2  # numerics: likewise for a slow loop
MANY_TICKS = 24_000  # numerics: of recordings, of which more ask for longer ticks
SHORT_TICK_S = 2.5e-3  # numerics: in which the linear model of a loop is nearly exact
NOT_ZERO = 1e-9  # numerics: of a parameter's scale
STIFFER = (0.05, 20.0)  # numerics: times the model so far
HOPELESS = 4.0  # numerics: times the least loss, at which a fit that gains little is given up


# a model, and what it leaves of the fitted samples on every tick
Known = tuple[tuple[Layout, np.ndarray], np.ndarray]


@dataclass(frozen=True)
class Start:
    """Where a fit begins.

    Attributes:
        layout, u: all terms and their parameters.
        columns: derivatives (nsample,) of the fitted samples, by slot key, where they are known.
    """

    layout: Layout
    u: np.ndarray
    columns: dict[tuple, np.ndarray] = field(default_factory=dict)


def names_of(layout: Layout) -> set[tuple[str, tuple[int, ...]]]:
    """Effects and the joints that have them."""
    return {(term.effect.name, term.joints) for term in layout.terms}


@dataclass(frozen=True)
class FittedSet:
    """A model with more terms, fitted.

    Attributes:
        layout, u: all terms and their parameters.
        residual: (nsample,) of the fitted samples, rad, predicted minus measured.
        left_out: (nsample,) likewise, each fold by a fit to the others, where these tell what the
            model says; elsewhere, as beyond the positions of a curve that they went to, as fitted.
        told: (nsample,) bool, where they tell.
        jacobian: (nsample, n).
        free: (n,) bool, which were fitted.
    """

    layout: Layout
    u: np.ndarray
    residual: np.ndarray
    left_out: np.ndarray
    told: np.ndarray
    jacobian: np.ndarray
    free: np.ndarray

    @property
    def model(self) -> tuple[Layout, np.ndarray]:
        """Layout and u."""
        return self.layout, self.u

    @property
    def known(self) -> "Known":
        """The model with what it leaves."""
        return self.model, self.residual

    @property
    def rmse(self) -> float:
        """Of the fitted samples."""
        return float(np.sqrt(np.mean(self.residual**2)))

    @property
    def left_out_rmse(self) -> float:
        """What decides."""
        return float(np.sqrt(np.mean(self.left_out**2)))

    @cached_property
    def complexity(self) -> int:
        """How many numbers the samples tell of those that were chosen; a name counts as one."""
        fixed = self.layout.lower >= self.layout.upper
        rough = int((~self.free & ~fixed).sum())
        told = independent(self.jacobian[:, self.free].T @ self.jacobian[:, self.free])
        return told + rough + len(self.layout.terms)

    @property
    def columns(self) -> dict[tuple, np.ndarray]:
        """Of the Jacobian, by slot key."""
        keys = (slot.key for slot in self.layout.slots)
        return {key: self.jacobian[:, i] for i, key in enumerate(keys) if self.free[i]}

    @property
    def names(self) -> set[tuple[str, tuple[int, ...]]]:
        """Effects and the joints that have them."""
        return names_of(self.layout)


@dataclass(frozen=True)
class Samples:
    """What is fitted: the samples of a predictor, at fewer ticks for all but the last steps.

    Attributes:
        exact, draft: predictors of the same recordings.
        linear: likewise, at ticks that are short for a loop.
        mask: (nsample,) bool.
        folds: (nfitted,) of the samples of `mask`.
        noise_rad: of a sample.
    """

    exact: Predictor
    draft: Predictor
    linear: Predictor
    mask: np.ndarray
    folds: np.ndarray
    noise_rad: float = 0.0

    @classmethod
    def of(
        cls,
        exact: Predictor,
        mask: np.ndarray,
        folds: np.ndarray,
        model: tuple[Layout, np.ndarray],
        noise_rad: float,
    ) -> "Samples":
        """With ticks for the linear model as coarse as the model so far allows.

        Where there are very many ticks, longer ones may serve while much is missing.
        """
        whole = cls(exact, exact, exact, mask, folds, noise_rad)
        slowest = min(recording.control_rate_hz for recording in exact.recordings)
        ticks = sum(r.duration_s * r.control_rate_hz for r in exact.recordings)
        shorter, longer = SHORT_TICK_S * slowest, min(LONG_TICK_S * slowest, ticks / MANY_TICKS)
        known = whole._exactly(model)
        missing = float(np.sqrt(np.mean((known - exact.samples.q)[mask] ** 2)))
        much = max(noise_rad, MATERIAL * missing)
        limits = {c: much for c in COARSENESS if shorter < c <= longer}
        limits |= {c: noise_rad for c in COARSENESS if c <= shorter}
        return replace(whole, linear=whole._coarse(limits, model, known))

    def drafted(self, model: tuple[Layout, np.ndarray], left_rad: float) -> "Samples":
        """With drafts at ticks as coarse as a model allows that is to leave so much.

        What they are off by there adds a tenth to it.
        """
        slowest = min(recording.control_rate_hz for recording in self.exact.recordings)
        longest = max(SHORT_TICK_S * slowest, COARSEST)
        limits = {c: HALF * max(left_rad, self.noise_rad) for c in COARSENESS if c <= longest}
        return replace(self, draft=self._coarse(limits, model, self._exactly(model)))

    def _exactly(self, model: tuple[Layout, np.ndarray]) -> np.ndarray:
        """Position (nsample,) on every tick."""
        layout, u = model
        return self.exact.predict([Request(layout, u[None])])[0][0]

    def _coarse(
        self, limits: Mapping[int, float], model: tuple[Layout, np.ndarray], known: np.ndarray
    ) -> Predictor:
        """The first of some coarsenesses that is less off `known` than its limit, rad."""
        layout, u = model
        for coarseness, limit_rad in limits.items():
            coarser = self.exact.of(self.exact.recordings, coarseness)
            change = coarser.predict([Request(layout, u[None])])[0][0] - known
            if np.sqrt(np.mean(change[self.mask] ** 2)) < limit_rad:
                return coarser
        return self.exact


class _Shifted(Positions):
    """Positions as coarser ticks predict them, less what these are off by at a known model."""

    def __init__(self, predictor: Predictor, mask: np.ndarray, shift: np.ndarray):
        super().__init__(predictor, mask)
        self.measured = self.measured + shift


class AlongMotion(Objective):
    """Positions by the linear model of the loop, from torques along the measured motion.

    Nothing is simulated: a torque is exact at any value of a parameter, only the loop's answer to
    what it has beyond what the motion takes is linear. So a model without a fault leaves only noise
    however far the model is of which the loop was linearised, a fit is as quick as a product of
    matrices, and it cannot run away.
    """

    def __init__(
        self,
        predictor: Predictor,
        sections: Sequence[Section],
        mask: np.ndarray,
        known: Known,
        noise_rad: float,
    ):
        self.predictor, self.sections, self.mask = predictor, sections, mask
        self.noise_rad = noise_rad
        self.base, self.residual = known
        self.joints = predictor.samples.joint[mask]
        self.answer = np.zeros(len(predictor.samples))
        if self.can_lead(self.base[0]):
            self.residual = self._residual()[mask]
        base = self.base[0], self.base[1][None]
        self.stiffness = [stiffness(predictor, section, [base])[0] for section in sections]

    def _residual(self) -> np.ndarray:
        """(nsample,) of the model so far."""
        samples = self.predictor.samples
        found = np.empty(len(samples))
        for section in self.sections:
            motion = section.motion
            answer = respond(section, excess(self.predictor, section, self.base)[..., None])[:, 0]
            self.answer[motion.group.held] = answer
            found[motion.group.held] = answer + at_samples(motion.group, motion.q)
        return found - samples.q

    def can_lead(self, layout: Layout) -> bool:
        """Whether a layout has no state besides the joints'."""
        return self.predictor.model(layout.terms).nv == len(self.predictor.joints)

    def residuals(self, asked: Sequence[tuple[Optimiser, np.ndarray]]) -> list[np.ndarray]:
        if not asked:
            return []
        variants = [(optimiser.layout, points) for optimiser, points in asked]
        counts = [len(points) for _, points in variants]
        moved = np.zeros((len(self.predictor.samples), sum(counts)))
        for section, own in zip(self.sections, self.stiffness, strict=True):
            torques = added_torques(self.predictor, section, self.base, variants)
            whole = np.concatenate([np.moveaxis(t, 1, -1) for t in torques], axis=-1)
            held = section.motion.group.held
            before, joint = self.answer[held, None], self.predictor.samples.joint[held]
            stiffer = np.concatenate(stiffness(self.predictor, section, variants)) / own
            stiffer = np.clip(np.where(own > 0, stiffer, 1.0), *STIFFER).T
            moved[held] = (before + respond(section, whole)) / stiffer[joint] - before
        moved = self.residual[:, None] + moved[self.mask]
        return np.split(moved.T, np.cumsum(counts)[:-1])


def fit_along(
    starts: Sequence[Start],
    objective: AlongMotion,
    folds: np.ndarray,
    iterations: int = ITERATIONS,
) -> list[FittedSet]:
    """Fit layouts from their starts along the measured motion.

    What has no derivative is tried at other values, of which the best goes on.
    """
    noise = objective.noise_rad
    fits = [
        LeastSquares(
            s.layout, s.u.copy(), _sizes(s), noise=noise, given=dict(s.columns),
            secant=bool(s.columns),
        )
        for s in starts
    ]  # fmt: skip
    if fits:
        minimise(fits, objective, iterations)
    if iterations:
        fits = [_best_of(fit, objective) if _steps(fit) else fit for fit in fits]
    return fitted(fits, objective, folds, at_once=True)


def _best_of(fit: LeastSquares, objective: AlongMotion) -> LeastSquares:
    """The best with other values of what has no derivative, ever nearer to it."""
    for times in ROUGH_STEPS:
        others = []
        for i in _steps(fit):
            for step in (-times, times):
                u = fit.u.copy()
                u[i] = np.clip(
                    u[i] + step * _unit(fit.layout, i), fit.layout.lower[i], fit.layout.upper[i]
                )
                others.append(LeastSquares(fit.layout, u, fit.size, noise=fit.noise))
        minimise(others, objective, ROUGH_ITERATIONS)
        fit = min([fit, *others], key=lambda one: one.loss)
    return fit


def _steps(fit: LeastSquares) -> list[int]:
    """Elements without a derivative that may have any value of a range."""
    layout = fit.layout
    wide = layout.rough & (layout.lower < layout.upper)
    return [int(i) for i in np.flatnonzero(wide) if _unit(layout, i) > 0]


def _unit(layout: Layout, i: int) -> float:
    """By what an element without a derivative is moved, times `ROUGH_STEPS`."""
    return 1.0 if layout.log[i] else layout.slots[i].size


def _sizes(start: Start) -> np.ndarray:
    stated = np.array([s.size for s in start.layout.slots])
    return np.maximum(np.maximum(np.abs(start.u), stated), _least(start.layout))


def begun(adopted: tuple[Layout, np.ndarray], screen: Screen, members: Sequence[int]) -> Start:
    """The adopted terms with a set of candidates, at the weights that the screen gives them."""
    layout, u = adopted
    weights, chosen = screen.weights(members), screen.chosen(members)
    gone = {member.effect.name for member in chosen if member.removal}
    chosen = [member for member in chosen if not member.removal]
    values = {slot.key: value for slot, value in zip(layout.slots, u, strict=True)}
    joints: dict[str, set[int]] = {}
    effects = {}
    for term in layout.terms:
        if term.effect.name not in gone:
            joints[term.effect.name], effects[term.effect.name] = set(term.joints), term.effect
    for member in chosen:
        name = member.effect.name
        effects[name] = member.effect
        joints.setdefault(name, set()).update(member.joints)
    if screen.table.base:
        free = [slot.key for slot in layout.slots if not slot.parameter.rough]
        for k, moved in zip(screen.kept(members), weights, strict=False):
            values[free[k]] += moved
    at = len(screen.kept(members))
    new: dict[tuple, float] = {}
    for member in chosen:
        name = member.effect.name
        for (parameter, joint), start in member.setting.items():
            new.setdefault((name, parameter, joint), start)
        for column in member.columns:
            if column.parameter is not None:
                new[name, column.parameter, column.joint] += weights[at]
            at += 1
    whole = Layout([Term(effects[name], tuple(sorted(of))) for name, of in joints.items()])
    start = np.array([values[s.key] if s.key in values else new[s.key] for s in whole.slots])
    return Start(whole, np.clip(start, whole.lower, whole.upper))


def fit_sets(
    starts: Sequence[Start],
    samples: Samples,
    known: Known | None = None,
    iterations: int = ITERATIONS,
    # numerics: at first
    damping: float = 1e-2,
) -> list[FittedSet]:
    """Fit layouts from their starts, on the draft; those that run away are left out.

    Args:
        known: a model, and what it leaves of the fitted samples on every tick.
        damping: at first.
    """
    if not starts:
        return []
    fits = []
    for start in starts:
        fits.append(
            LeastSquares(
                start.layout, start.u.copy(), _sizes(start), damping=damping,
                given=dict(start.columns), secant=True, noise=samples.noise_rad,
                last=None if start.columns else iterations,
            )
        )  # fmt: skip
    shift = 0.0
    if known is not None and samples.draft is not samples.exact:
        (layout, u), residual = known
        coarse = samples.draft.predict([Request(layout, u[None])])[0][0][samples.mask]
        shift = coarse - (residual + samples.draft.samples.q[samples.mask])
    objective = _Shifted(samples.draft, samples.mask, shift)

    def give_up(fits):
        least = min(fit.loss for fit in fits)
        for fit in fits:
            # numerics: a round that gains less is near its end
            if fit.iterations >= 2 and fit.loss > HOPELESS * least and fit.gain < 0.3:
                fit.done = True

    minimise(fits, objective, iterations, give_up)
    return fitted(fits, objective, samples.folds)


def _least(layout: Layout) -> np.ndarray:
    """(n,) in place of a size of zero."""
    return NOT_ZERO * np.array([slot.scale for slot in layout.slots])


def refine(
    sets: Sequence[FittedSet],
    samples: Samples,
    known: Known,
) -> list[FittedSet]:
    """The same with derivatives by simulation."""
    starts = [Start(one.layout, one.u) for one in sets]
    return fit_sets(starts, samples, known, REFINING, NEAR_ITS_END)


def finish(sets: Sequence[FittedSet], samples: Samples) -> list[FittedSet]:
    """The same on every tick, with the derivatives that they have."""
    if samples.draft is samples.exact or not sets:
        return list(sets)
    fits = []
    for one in sets:
        size = np.maximum(np.abs(one.u), _least(one.layout))
        fits.append(
            LeastSquares(
                one.layout, one.u.copy(), size, free=one.free, damping=NEAR_ITS_END,
                given=one.columns, secant=True, noise=samples.noise_rad,
            )
        )  # fmt: skip
    objective = Positions(samples.exact, samples.mask)
    minimise(fits, objective, FINISHING)
    return fitted(fits, objective, samples.folds)


def fitted(
    fits: Sequence[LeastSquares], objective: Objective, folds: np.ndarray, at_once: bool = False
) -> list[FittedSet]:
    """Fits with what they leave on each fold when the others fit them; not those that ran away.

    Args:
        objective: that they were fitted by.
        at_once: ask for all dampings of a step in one call.
    """
    fits = [fit for fit in fits if np.isfinite(fit.loss) and fit.jacobian is not None]
    each = [_LeftOut(fit, folds) for fit in fits if fit.free.any()]
    # along a motion many points take hardly longer than one
    for dampings in [DAMPINGS] if at_once else [(damping,) for damping in DAMPINGS]:
        some = [one for one in each if len(one.open)]
        asked = [(one.fit, one.points(dampings)) for one in some]
        for one, residuals in zip(some, objective.residuals(asked), strict=True):
            one.receive(residuals)
    left = {id(one.fit): (one.left_out, one.told) for one in each}
    found = []
    for fit in fits:
        left_out, told = left.get(id(fit), (fit.residual, np.ones(len(folds), bool)))
        if np.isfinite(left_out).all():
            found.append(
                FittedSet(
                    fit.layout, fit.u, fit.residual, left_out, told, fit.jacobian, fit.free
                )
            )  # fmt: skip
    return found


class _LeftOut:
    """What a fit leaves of each part when the others fit it: a step of Gauss and Newton away.

    A step that makes the error of the others larger is too long, and a more damped one is tried
    (Marquardt, 1963). If none is shorter, the fit to all is that to the others too.

    Attributes:
        left_out: (nsample,) rad, as far as it is known; as fitted where the others do not tell it.
        told: (nsample,) bool, where the others tell what the model says: to a standard error below
            that of a sample.
        open: parts that no step is known for.
    """

    def __init__(self, fit: LeastSquares, folds: np.ndarray):
        self.fit, self.folds, free = fit, folds, np.flatnonzero(fit.free)
        self.free, self.open = free, np.unique(folds)
        jacobian, prior = fit.jacobian[:, free], fit.prior[:, free]
        self.size = np.sqrt((jacobian**2).sum(axis=0) + (prior**2).sum(axis=0)) + TINY
        self.jacobian, self.prior = jacobian / self.size, prior / self.size
        self.normal = self.jacobian.T @ self.jacobian + self.prior.T @ self.prior
        self.slope = self.jacobian.T @ fit.residual + self.prior.T @ (fit.prior @ fit.u)
        # what no part tells stays where it is
        values, directions = np.linalg.eigh(self.normal)
        held = directions[:, values < ALIKE]
        self.held = held @ held.T
        self.told = np.empty(len(folds), bool)
        for fold in self.open:
            mine = self.jacobian[folds == fold]
            inverse = np.linalg.inv(self._others(mine, RIDGE))
            spread = np.einsum("ij,jk,ik->i", mine, inverse, mine, optimize=True)
            self.told[folds == fold] = spread < 1
        if self.told.mean() < HALF:
            self.told[:] = True
        self.left_out = fit.residual.copy()

    def _others(self, mine: np.ndarray, damping: float) -> np.ndarray:
        return self.normal - mine.T @ mine + damping * np.eye(len(self.free)) + self.held

    def points(self, dampings: Sequence[float]) -> np.ndarray:
        """Parameters (nopen · ndamping, n) that fit all but each of the open parts in turn."""
        fit, free = self.fit, self.free
        u, lower, upper = (x[free] for x in (fit.u, fit.layout.lower, fit.layout.upper))
        log = fit.layout.log[free]
        lower = np.where(log, np.maximum(lower, u - FARTHEST), lower)
        upper = np.where(log, np.minimum(upper, u + FARTHEST), upper)
        within = ((lower - u) * self.size, (upper - u) * self.size)
        # what the others alone say nothing of is not known there: it has no effect
        neutral = fit.layout.neutral[free]
        away = RIDGE * np.where(np.isfinite(neutral), u - neutral, 0.0) * self.size
        self._asked = []
        for fold in self.open:
            at = self.folds == fold
            mine = self.jacobian[at]
            target = mine.T @ fit.residual[at] - self.slope - away
            for damping in dampings:
                rest, found = self._others(mine, damping), fit.u.copy()
                found[free] += bounded(*(x[None] for x in (rest, target, *within)))[0] / self.size
                self._asked.append((fold, found))
        return np.array([found for _, found in self._asked])

    def receive(self, residuals: np.ndarray) -> None:
        """Take the residuals (nopen · ndamping, nsample) at `points`; the first step serves."""
        fit, done = self.fit, set()
        before = fit.residual**2
        for (fold, u), residual in zip(self._asked, residuals, strict=True):
            others = self.folds != fold
            known = np.sum((fit.prior @ fit.u) ** 2) - np.sum((fit.prior @ u) ** 2)
            least = before[others].sum() + known + LONGER * fit.loss
            if fold not in done and np.sum(residual[others] ** 2) <= least:
                at = ~others & self.told
                self.left_out[at] = residual[at]
                done.add(fold)
        self.open = np.array([fold for fold in self.open if fold not in done])
