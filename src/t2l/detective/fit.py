"""Sets of candidates fitted in full simulation, from where the linear model leads."""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from t2l.detective.screen import Screen
from t2l.effects.term import Layout, Term
from t2l.identify.fitting import PositionError as Positions
from t2l.identify.least_squares import LeastSquares
from t2l.identify.levels import AT_THE_FLOOR
from t2l.identify.optimiser import minimise
from t2l.identify.prediction import Predictor, Request

ITERATIONS = 5  # numerics: of a fit with the derivatives of the linear model
REFINING = 2  # numerics: more, with derivatives by simulation
FINISHING = 3  # numerics: on every tick, with the derivatives of coarser ones
NEAR_ITS_END = 1e-3  # numerics: damping of a fit that begins there
RIDGE = 1e-6  # numerics: of a column's sum of squares
NOT_ZERO = 1e-9  # numerics: of a parameter's scale
COARSENESS = (5, 4, 2)  # numerics: control periods a tick that are tried
HOPELESS = 4.0  # numerics: times the least loss, at which a fit that gains little is given up


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


@dataclass(frozen=True)
class FittedSet:
    """A model with more terms, fitted.

    Attributes:
        layout, u: all terms and their parameters.
        residual: (nsample,) of the fitted samples, rad, predicted minus measured.
        left_out: (nsample,) likewise, each fold by a fit to the others.
        jacobian: (nsample, n).
        free: (n,) bool, which were fitted.
    """

    layout: Layout
    u: np.ndarray
    residual: np.ndarray
    left_out: np.ndarray
    jacobian: np.ndarray
    free: np.ndarray

    @property
    def rmse(self) -> float:
        """Of the fitted samples."""
        return float(np.sqrt(np.mean(self.residual**2)))

    @property
    def left_out_rmse(self) -> float:
        """What decides."""
        return float(np.sqrt(np.mean(self.left_out**2)))

    @property
    def parameters(self) -> int:
        """How many numbers were fitted."""
        return int(self.free.sum())

    @property
    def columns(self) -> dict[tuple, np.ndarray]:
        """Of the Jacobian, by slot key."""
        keys = (slot.key for slot in self.layout.slots)
        return {key: self.jacobian[:, i] for i, key in enumerate(keys) if self.free[i]}

    @property
    def names(self) -> set[tuple[str, tuple[int, ...]]]:
        """Effects and the joints that have them."""
        return {(t.effect.name, t.joints) for t in self.layout.terms}


@dataclass(frozen=True)
class Samples:
    """What is fitted: the samples of a predictor, at fewer ticks for all but the last steps.

    Attributes:
        exact, draft: predictors of the same recordings.
        mask: (nsample,) bool.
        folds: (nfitted,) of the samples of `mask`.
    """

    exact: Predictor
    draft: Predictor
    mask: np.ndarray
    folds: np.ndarray

    @classmethod
    def of(
        cls,
        exact: Predictor,
        mask: np.ndarray,
        folds: np.ndarray,
        model: tuple[Layout, np.ndarray],
        noise_rad: float,
    ) -> "Samples":
        """With ticks as coarse as the model so far allows; their error is taken from the target.

        So it may be as large as the noise, but not as what is missing.
        """
        layout, u = model
        request = Request(layout, u[None])
        known = exact.predict([request])[0][0]
        missing = np.sqrt(np.mean((known - exact.samples.q)[mask] ** 2))
        limit = max(noise_rad, missing / AT_THE_FLOOR / 5)
        for coarseness in COARSENESS:
            draft = exact.of(exact.recordings, coarseness)
            change = draft.predict([request])[0][0] - known
            if np.sqrt(np.mean(change[mask] ** 2)) < limit:
                return cls(exact, draft, mask, folds)
        return cls(exact, exact, mask, folds)


class _Shifted(Positions):
    """Positions as coarser ticks predict them, less what these are off by at a known model."""

    def __init__(self, predictor: Predictor, mask: np.ndarray, shift: np.ndarray):
        super().__init__(predictor, mask)
        self.measured = self.measured + shift


def begun(adopted: tuple[Layout, np.ndarray], screen: Screen, members: Sequence[int]) -> Start:
    """The adopted terms with a set of candidates, at the weights that the screen gives them."""
    layout, u = adopted
    weights, chosen = screen.weights(members), screen.chosen(members)
    values = {slot.key: value for slot, value in zip(layout.slots, u, strict=True)}
    joints: dict[str, set[int]] = {}
    effects = {}
    for term in layout.terms:
        joints[term.effect.name], effects[term.effect.name] = set(term.joints), term.effect
    for member in chosen:
        name = member.effect.name
        effects[name] = member.effect
        joints.setdefault(name, set()).update(member.joints)
    table, new, known = screen.table, {}, {}
    if len(table.base):
        soft = [slot.key for slot in layout.slots if not slot.parameter.rough]
        known = {k: table.columns[:, at] for k, at in zip(soft, table.base, strict=True)}
    at = len(table.base)
    for member in chosen:
        name = member.effect.name
        for (parameter, joint), start in member.setting.items():
            new.setdefault((name, parameter, joint), start)
        for column in member.columns:
            if column.parameter is not None:
                key = name, column.parameter, column.joint
                new[key] += weights[at]
                known[key] = table.columns[:, column.at]
            at += 1
    whole = Layout([Term(effects[name], tuple(sorted(of))) for name, of in joints.items()])
    start = np.array([values[s.key] if s.key in values else new[s.key] for s in whole.slots])
    columns = {key: column.astype(float) for key, column in known.items()}
    return Start(whole, np.clip(start, whole.lower, whole.upper), columns)


def fit_sets(
    starts: Sequence[Start],
    samples: Samples,
    known: tuple[tuple[Layout, np.ndarray], np.ndarray] | None = None,
    iterations: int = ITERATIONS,
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
        stated = np.array([s.size for s in start.layout.slots])
        size = np.maximum(np.maximum(np.abs(start.u), stated), _least(start.layout))
        given = dict(start.columns)
        fits.append(
            LeastSquares(
                start.layout, start.u.copy(), size, damping=damping, given=given, secant=True
            )
        )
    shift = 0.0
    if known is not None and samples.draft is not samples.exact:
        (layout, u), residual = known
        coarse = samples.draft.predict([Request(layout, u[None])])[0][0][samples.mask]
        shift = coarse - (residual + samples.draft.samples.q[samples.mask])
    objective = _Shifted(samples.draft, samples.mask, shift)

    def give_up(fits):
        least = min(fit.loss for fit in fits)
        for fit in fits:
            if fit.iterations >= 2 and fit.loss > HOPELESS * least and fit.gain < 0.3:
                fit.done = True

    minimise(fits, objective, iterations, give_up)
    return [found for fit in fits if (found := fitted(fit, samples.folds)) is not None]


def _least(layout: Layout) -> np.ndarray:
    """(n,) in place of a size of zero."""
    return NOT_ZERO * np.array([slot.scale for slot in layout.slots])


def refine(
    sets: Sequence[FittedSet],
    samples: Samples,
    known: tuple[tuple[Layout, np.ndarray], np.ndarray],
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
                given=one.columns, secant=True,
            )
        )  # fmt: skip
    minimise(fits, Positions(samples.exact, samples.mask), FINISHING)
    return [found for fit in fits if (found := fitted(fit, samples.folds)) is not None]


def fitted(fit: LeastSquares, folds: np.ndarray) -> FittedSet | None:
    """A fit with what it leaves on each fold when the others fit it; to first order."""
    if not np.isfinite(fit.loss) or fit.residual is None or fit.jacobian is None:
        return None
    jacobian, residual = fit.jacobian, fit.residual
    left = residual.copy()
    free = np.flatnonzero(fit.free)
    if len(free):
        j = jacobian[:, free]
        size = np.sqrt((j**2).sum(axis=0)) + 1e-300
        j = j / size
        normal, slope = j.T @ j, j.T @ residual
        for fold in np.unique(folds):
            rows = folds == fold
            mine = j[rows]
            rest = normal - mine.T @ mine + RIDGE * np.eye(len(free))
            change = -np.linalg.solve(rest, slope - mine.T @ residual[rows])
            u = np.clip(fit.u[free] + change / size, fit.layout.lower[free], fit.layout.upper[free])
            left[rows] += mine @ ((u - fit.u[free]) * size)
    return FittedSet(fit.layout, fit.u, residual, left, jacobian, fit.free)
