"""Sets fitted along the measured motion: torques are exact there, the loop's answer is linear."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from t2l.detective.fitted_set import FittedSet, Known, Start, least_of_no_more, sizes
from t2l.detective.free_phases import FreePhases
from t2l.detective.held_torques import HeldTorques
from t2l.detective.left_out import fitted
from t2l.detective.linear_loop import Section, respond
from t2l.detective.motion import at_samples
from t2l.detective.responses import added_torques, excess, stiffness
from t2l.effects.term import Layout
from t2l.identify.least_squares import LeastSquares
from t2l.identify.optimiser import Objective, Optimiser, minimise
from t2l.identify.prediction import Predictor

BEHIND = 4.0  # numerics: times the loss, which is twice the error
ITERATIONS = 5  # numerics: of a fit
# numerics: of the logarithm of what has no derivative, one after the other
ROUGH_STEPS = (0.3, 0.15, 0.08, 0.04, 0.02)
ROUGH_ITERATIONS = 2  # numerics: of the others meanwhile
STIFFER = (0.05, 20.0)  # numerics: times the model so far


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
        self.noise_rad, self.recordings = noise_rad, len(predictor.recordings)
        self.base = known[0]
        self.joints = predictor.samples.joint[mask]
        self.answer = np.zeros(len(predictor.samples))
        self.residual = self._residual()[mask]
        # of each sample among the fitted ones
        self.place = np.where(mask, np.cumsum(mask) - 1, -1)
        self.held_torques = HeldTorques(predictor, sections, self.place, noise_rad)
        self.free_phases = FreePhases(predictor, sections, np.flatnonzero(mask))
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
            found[motion.group.held] = answer + at_samples(motion.group, motion.q, motion.dq)
        return found - samples.q

    @property
    def rmse(self) -> float:
        """Of the model so far, rad; not a number where the loop runs away."""
        layout, u = self.base
        as_stiff = [[np.ones((1, len(self.predictor.joints)))]] * len(self.sections)
        (left,) = self._freed([(layout, u[None])], [self.residual[None]], as_stiff)
        return float(np.sqrt(np.mean(left**2)))

    def residuals(self, asked: Sequence[tuple[Optimiser, np.ndarray]]) -> list[np.ndarray]:
        if not asked:
            return []
        n = len(self.predictor.joints)
        pairs = [together(optimiser.layout, points, n) for optimiser, points in asked]
        variants = [(one.layout, rows) for (one, _), (rows, _) in zip(asked, pairs, strict=True)]
        rows = [of for _, of in pairs]
        counts = [len(points) for _, points in asked]
        left = np.repeat(self.residual[:, None], sum(counts), axis=1)
        divided = []
        for section, own in zip(self.sections, self.stiffness, strict=True):
            torques = added_torques(self.predictor, section, self.base, variants)
            torques = [of_joints(t, of, 1) for t, of in zip(torques, rows, strict=True)]
            whole = np.concatenate([np.moveaxis(t, 1, -1) for t in torques], axis=-1)
            chosen = self.mask[section.motion.group.held]
            held = section.motion.group.held[chosen]
            moved = respond(section, whole, chosen=chosen)
            stiff = stiffness(self.predictor, section, variants)
            stiff = [of_joints(k, of, 0) for k, of in zip(stiff, rows, strict=True)]
            stiffer = np.concatenate(stiff) / own
            stiffer = np.clip(np.where(own > 0, stiffer, 1.0), *STIFFER).T
            divided.append(np.split(stiffer.T, np.cumsum(counts)[:-1]))
            if (stiffer != 1).any():
                before, joint = self.answer[held, None], self.predictor.samples.joint[held]
                moved = (before + moved) / stiffer[joint] - before
            left[self.place[held]] += moved
        each = np.split(left.T, np.cumsum(counts)[:-1])
        return self._freed([(one.layout, points) for one, points in asked], each, divided)

    def _freed(self, asked, residuals, divided) -> list[np.ndarray]:
        """Residuals of points of layouts, less what the beginnings of recordings may explain."""
        turned = self.free_phases.turned(asked, residuals, divided)
        return self.held_torques.freed(asked, turned)


def together(layout: Layout, points: np.ndarray, njoint: int) -> tuple[np.ndarray, np.ndarray]:
    """Fewer points that have the torques of all, where a joint's numbers move its torque alone.

    Points that differ from the first in one number, each of another joint, are one.

    Args:
        points: (m, n) of a layout.

    Returns:
        (k, n), and (m, njoint) which of them has each joint's torque.
    """
    alone = np.full(len(layout.slots), -1)
    if not any(term.effect.extends or term.effect.shares for term in layout.terms):
        for i, slot in enumerate(layout.slots):
            if slot.joint is not None and not slot.term.effect.coupled:
                alone[i] = slot.joint
    rows, of = [points[0].copy()], np.zeros((len(points), njoint), int)
    # joints that each row moves; none has room beside what moves more than one number
    taken: list[set[int]] = [set(range(njoint))]
    for m, point in enumerate(points[1:], start=1):
        moved = np.flatnonzero(point != points[0])
        joint = int(alone[moved[0]]) if len(moved) == 1 else -1
        if joint < 0:
            of[m] = len(rows)
            rows.append(point)
            taken.append(set(range(njoint)))
            continue
        row = next((i for i, joints in enumerate(taken) if joint not in joints), len(rows))
        if row == len(rows):
            rows.append(points[0].copy())
            taken.append(set())
        rows[row][moved] = point[moved]
        taken[row].add(joint)
        of[m, joint] = row
    return np.array(rows), of


def of_joints(values: np.ndarray, of: np.ndarray, axis: int) -> np.ndarray:
    """Of rows along an axis those of each joint, the last axis, see `together`."""
    values = np.moveaxis(values, axis, 0)
    shape = (len(of), *(1,) * (values.ndim - 2), of.shape[1])
    return np.moveaxis(np.take_along_axis(values, of.reshape(shape), axis=0), 0, axis)


def fit_along(
    starts: Sequence[Start],
    objective: AlongMotion,
    folds: np.ndarray,
    iterations: int = ITERATIONS,
    racing: bool = False,
) -> list[FittedSet]:
    """Fit layouts from their starts along the measured motion.

    What has no derivative is tried at other values, of which the best goes on.

    Args:
        racing: whether those end early that fall far behind others, see `race`.
    """
    noise = objective.noise_rad
    starts = _nearer(starts, objective)
    fits = [
        LeastSquares(
            s.layout, s.u.copy(), sizes(s), noise=noise, given=dict(s.columns),
            secant=bool(s.columns),
        )
        for s in starts
    ]  # fmt: skip
    if fits:
        minimise(fits, objective, iterations, race if racing else lambda fits: None)
    if iterations:
        least = _least(fits) if racing else [np.inf] * len(fits)
        fits = [
            _best_of(fit, objective) if _steps(fit) and fit.loss <= BEHIND * best else fit
            for fit, best in zip(fits, least, strict=True)
        ]
    return fitted(fits, objective, folds, racing)


def _nearer(starts: Sequence[Start], objective: AlongMotion) -> list[Start]:
    """Each where it leaves less: where it begins, or with unmoved numbers of the set before."""
    two = [LeastSquares(s.layout, s.u, sizes(s)) for s in starts if s.unmoved is not None]
    asked = [s for s in starts if s.unmoved is not None]
    points = [np.stack([s.u, s.unmoved]) for s in asked]
    left = objective.residuals([*zip(two, points, strict=True)])
    best = {}
    for one, places, residuals in zip(asked, points, left, strict=True):
        loss = np.nan_to_num(np.mean(residuals**2, axis=1), nan=np.inf)
        best[id(one)] = places[int(np.argmin(loss))]
    return [replace(s, u=best.get(id(s), s.u)) for s in starts]


def race(fits: Sequence[LeastSquares]) -> None:
    """End fits that promise to stay far behind one with no more effects.

    Source: Maron and Moore, Hoeffding races, 1994; here it is the linear model that promises.
    """
    for fit, best in zip(fits, _least(fits), strict=True):
        if fit.iterations and not fit.done:
            fit.done = fit.loss * (1 - fit.promise()) > BEHIND * best


def _least(fits: Sequence[LeastSquares]) -> list[float]:
    """For each the least loss of those with no more effects."""
    return least_of_no_more([fit.loss for fit in fits], [fit.layout for fit in fits])


def _best_of(fit: LeastSquares, objective: AlongMotion) -> LeastSquares:
    """The best with other values of what has no derivative, ever nearer to it.

    They have the derivatives of the first meanwhile, as their steps correct these.
    """
    first = fit
    for times in ROUGH_STEPS:
        others = []
        for i in _steps(fit):
            for step in (-times, times):
                u = fit.u.copy()
                u[i] = np.clip(
                    u[i] + step * _unit(fit.layout, i), fit.layout.lower[i], fit.layout.upper[i]
                )
                others.append(
                    LeastSquares(
                        fit.layout, u, fit.size, noise=fit.noise, given=fit.columns(), secant=True
                    )
                )
        minimise(others, objective, ROUGH_ITERATIONS)
        fit = min([fit, *others], key=lambda one: one.loss)
    if fit is not first:
        fit = LeastSquares(fit.layout, fit.u, fit.size, noise=fit.noise)
        minimise([fit], objective, ROUGH_ITERATIONS)
    return fit


def _steps(fit: LeastSquares) -> list[int]:
    """Elements without a derivative that may have any value of a range."""
    layout = fit.layout
    wide = layout.rough & (layout.lower < layout.upper)
    return [int(i) for i in np.flatnonzero(wide) if _unit(layout, i) > 0]


def _unit(layout: Layout, i: int) -> float:
    """By what an element without a derivative is moved, times `ROUGH_STEPS`."""
    return 1.0 if layout.log[i] else layout.slots[i].size
