"""Formulas judged, and their constants fitted, through the simulation.

Constants that fit a learned curve best carry what smoothed it, and say little beyond its ends.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from t2l.effects.law import GRID, Curve, Law
from t2l.identify.block_bootstrap import blocks
from t2l.identify.levels import AT_THE_FLOOR
from t2l.identify.model import Model
from t2l.identify.prediction import Predictor, Request
from t2l.propose.cross_validation import left_out
from t2l.propose.expression import Formula
from t2l.propose.formula import Fitted, candidates, chosen, extent, installed, promising
from t2l.propose.proposal import Learned, Proposal, pooled_error
from t2l.typed import LARGEST

Sets = Sequence[tuple[Predictor, np.ndarray]]

NEAR = AT_THE_FLOOR  # as near as an error must be to that of a curve
COARSE = 4  # numerics: control periods a tick, for all but the last steps of a fit
STEP = 1e-2  # numerics: of a constant: a difference that the kinks of friction do not hide
LEAST = 1e-9  # numerics: no constant is smaller
# numerics: of the squared error: what gains less in a step has settled; where constants do much the
# same, as of a decay that is seen in part, a step gains a few thousandths
SETTLED = 1e-3
TOLERANCE = 0.01  # numerics: likewise, in a round of all formulas
FAR = 1e3  # numerics: rad, of a simulation that ran away


@dataclass(frozen=True)
class Simulation:
    """What formulas leave of recordings in the place of a curve, all else in the model as it is.

    Attributes:
        one: the learned law that they stand for. They are simulated as far as it reaches.
        beside: the model without it.
        sets: predictors, and the samples of each, (nsample,) bool.
        limit: rad, the most that a formula may leave.
    """

    one: Learned
    beside: Model
    sets: Sets
    limit: float

    @classmethod
    def of(
        cls, proposal: Proposal, one: Learned, sets: Sets, beside: Mapping[Law, Formula]
    ) -> "Simulation":
        """In the place of `one` of the curves of a proposal.

        Args:
            beside: formulas in place of others.
        """
        rest = _without(proposal, one, beside)
        whole = replace(rest, learned=(*rest.learned, one.curve))
        limit = NEAR * max(proposal.noise_floor_rad, pooled_error(whole, sets))
        return cls(one, rest, sets, limit)

    def errors(self, formulas: Sequence[Formula]) -> list[float]:
        """RMS error in rad of each."""
        return [rms(left) for left in self._left(formulas, self.sets)] if formulas else []

    @cached_property
    def block(self) -> np.ndarray:
        """(nsample,) which block of time a sample belongs to."""
        found, count = [], 0
        for predictor, mask in self.sets:
            samples = predictor.samples
            found.append(count + blocks(samples.recording[mask], samples.time[mask]))
            count += found[-1].max(initial=-1) + 1
        return np.concatenate(found)

    def fitted(self, formula: Formula) -> Fitted:
        """The formula with the constants that leave least, near those that it has."""
        from scipy.optimize import least_squares

        names = list(formula.values)
        start = np.array([formula.values[name] for name in names])
        size = np.abs(start) + LEAST
        # the coarser simulation serves for changes only
        whole, first = (self._left([formula], sets)[0] for sets in (self.sets, self._coarse))
        sets, shift = (self._coarse, whole - first) if rms(first) < FAR else (self.sets, 0.0)

        def left(points: Sequence[np.ndarray]) -> np.ndarray:
            made = [
                replace(formula, values=dict(zip(names, p.tolist(), strict=True))) for p in points
            ]
            return self._left(made, sets) + shift

        def slopes(values: np.ndarray) -> np.ndarray:
            here, *there = left([values, *(values + STEP * np.diag(size))])
            return (np.array(there) - here).T / (STEP * size)

        # until it settles: one that is cut off loses to a formula that settles sooner
        best = least_squares(
            lambda values: left([values])[0], start, slopes, x_scale="jac", ftol=SETTLED
        )
        settled = replace(formula, values=dict(zip(names, best.x.tolist(), strict=True)))
        (whole,) = self._left([settled], self.sets)
        return Fitted(settled, rms(whole), left_out(best.jac, whole, self.block))

    @cached_property
    def _coarse(self) -> Sets:
        """The same samples, on coarser ticks."""
        return [(predictor.of(predictor.recordings, COARSE), mask) for predictor, mask in self.sets]

    def _left(self, formulas: Sequence[Formula], sets: Sets) -> np.ndarray:
        """(n, nsample) rad, measured minus predicted; `FAR` where a simulation runs away."""
        curves = [_drawn(formula, self.one) for formula in formulas]
        # of a larger torque slopes are no finite numbers; NaN is not smaller
        finite = np.array([(np.abs(curve.torque) <= LARGEST).all() for curve in curves])
        left = np.full((len(formulas), sum(mask.sum() for _, mask in sets)), FAR)
        if finite.any():
            learned = self.beside.learned
            models = [
                replace(self.beside, learned=(*learned, curves[i])) for i in np.flatnonzero(finite)
            ]
            parts = [_residuals(models, *each) for each in sets]
            left[finite] = np.nan_to_num(np.concatenate(parts, axis=1), nan=FAR)
        return left


def formulas_of(proposal: Proposal, sets: Sets) -> dict[Law, Formula]:
    """The formulas of those laws that have one; none without pyoperon."""
    if not installed():
        return {}
    found = {one.curve.law: [*candidates(one)] for one in proposal.learned}
    taken: dict[Law, Formula] = {}
    # those that came near again beside the formulas: what the curves beside one leave may hide
    # which of them is right
    for _ in range(min(len(found), 2)):
        for one in proposal.learned:
            law = one.curve.law
            judge = Simulation.of(proposal, one, sets, taken)
            fitted = promising(found[law], judge)
            found[law] = [each.formula for each in fitted]
            best = chosen(fitted, judge)
            taken.pop(law, None)
            if best:
                taken[law] = best
    return together(proposal, taken, sets)


def together(proposal: Proposal, found: Mapping[Law, Formula], sets: Sets) -> dict[Law, Formula]:
    """Formulas with constants that fit beside the other formulas, not beside their curves.

    In turn, as in backfitting (Breiman and Friedman, 1985), as long as that gains.
    """
    found, gain = dict(found), float(len(found) > 1)
    left = pooled_error(in_words(proposal, found), sets) if gain else 0.0
    while gain > TOLERANCE:
        changed = dict(found)
        for one in proposal.learned:
            if one.curve.law in changed:
                rest = _without(proposal, one, changed)
                beside = Simulation(one, rest, sets, np.inf)
                changed[one.curve.law] = beside.fitted(changed[one.curve.law]).formula
        now = pooled_error(in_words(proposal, changed), sets)
        gain = 1 - (now / left) ** 2
        if gain > 0:
            found, left = changed, now
    return found


def _without(proposal: Proposal, one: Learned, formulas: Mapping[Law, Formula]) -> Model:
    """The model with what was learned but one law, others as their formulas where they have one."""
    others = tuple(other for other in proposal.learned if other is not one)
    return in_words(replace(proposal, learned=others), formulas)


def in_words(proposal: Proposal, formulas: Mapping[Law, Formula]) -> Model:
    """The model with everything that was learned, laws as their formulas where they have one."""
    curves = []
    for one in proposal.learned:
        found = formulas.get(one.curve.law)
        curves.append(_drawn(found, one) if found else one.curve)
    return replace(proposal.model, learned=(*proposal.model.learned, *curves))


def _drawn(formula: Formula, one: Learned) -> Curve:
    """What a formula says in the place of a curve; it may say what is not finite."""
    at = np.linspace(*extent(formula, one), 3 * GRID)
    with np.errstate(over="ignore", invalid="ignore"):
        return replace(one.curve, at=tuple(at.tolist()), torque=tuple(formula(at).tolist()))


def _residuals(models: Sequence[Model], predictor: Predictor, mask: np.ndarray) -> np.ndarray:
    vectors = (model.vector(predictor.joints) for model in models)
    predicted = predictor.predict([Request(layout, u[None]) for layout, u in vectors])
    return np.array([(predictor.samples.q - q[0])[mask] for q in predicted])


def rms(values: np.ndarray) -> float:
    """Root mean square."""
    return float(np.sqrt(np.mean(values**2)))
