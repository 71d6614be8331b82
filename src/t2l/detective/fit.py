"""Sets of candidates fitted in full simulation, from where the linear model leads."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from t2l.detective.candidates import Candidate
from t2l.effects.term import Layout, Term
from t2l.identify.fitting import run
from t2l.identify.least_squares import LeastSquares
from t2l.identify.prediction import Predictor

ITERATIONS = 6  # numerics: of a fit that begins near its end
RIDGE = 1e-6  # numerics: of a column's sum of squares
MARGIN = 1e-3  # numerics: of a range, by which a start keeps off its ends


@dataclass(frozen=True)
class FittedSet:
    """A model with more terms, fitted.

    Attributes:
        layout, u: all terms and their parameters.
        residual: (nsample,) of the fitted samples, rad, predicted minus measured.
        left_out: (nsample,) likewise, each fold by a fit to the others.
        jacobian: (nsample, n).
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
    def names(self) -> set[tuple[str, tuple[int, ...]]]:
        """Effects and the joints that have them."""
        return {(t.effect.name, t.joints) for t in self.layout.terms}


def begun(
    adopted: tuple[Layout, np.ndarray],
    members: Sequence[Candidate],
    weights: np.ndarray,
    nbase: int,
) -> tuple[Layout, np.ndarray]:
    """Layout and start u of the adopted terms with a set of candidates.

    Args:
        weights: of the base's columns, and of the columns of the members in turn.
        nbase: how many columns the base has.
    """
    layout, u = adopted
    values = {slot.key: value for slot, value in zip(layout.slots, u, strict=True)}
    joints: dict[str, set[int]] = {}
    effects = {}
    for term in layout.terms:
        joints[term.effect.name], effects[term.effect.name] = set(term.joints), term.effect
    for member in members:
        name = member.effect.name
        effects[name] = member.effect
        joints.setdefault(name, set()).update(member.joints)
    new, at = {}, nbase
    for member in members:
        for (parameter, joint), start in member.setting.items():
            new.setdefault((member.effect.name, parameter, joint), start)
        for column in member.columns:
            if column.parameter is not None:
                new[member.effect.name, column.parameter, column.joint] += weights[at]
            at += 1
    whole = Layout([Term(effects[name], tuple(sorted(of))) for name, of in joints.items()])
    start = np.array([values[s.key] if s.key in values else new[s.key] for s in whole.slots])
    return whole, np.clip(start, whole.lower, whole.upper)


def fit_sets(
    starts: Sequence[tuple[Layout, np.ndarray]],
    predictor: Predictor,
    mask: np.ndarray,
    folds: np.ndarray,
    iterations: int = ITERATIONS,
) -> list[FittedSet | None]:
    """Fit layouts from their starts; None where every simulation runs away."""
    fits = []
    for layout, u in starts:
        stated = np.array([s.parameter.size for s in layout.slots])
        size = np.maximum(np.maximum(np.abs(u), stated), 1e-9)
        fits.append(LeastSquares(layout, u.copy(), size))
    run(fits, predictor, mask, iterations)
    return [fitted(fit, folds) for fit in fits]


def fitted(fit: LeastSquares, folds: np.ndarray) -> FittedSet | None:
    """A fit with what it leaves on each fold when the others fit it; to first order."""
    if not np.isfinite(fit.loss) or fit.residual is None:
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
