"""Sets of candidates fitted in full simulation, from where the linear model leads."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from t2l.detective.along_motion import AlongMotion
from t2l.detective.corrected import fit_corrected
from t2l.detective.fitted_set import FittedSet, Known, Start, sizes
from t2l.detective.left_out import fitted
from t2l.detective.screen import Screen
from t2l.effects.term import Layout, Term
from t2l.identify.fitting import PositionError as Positions
from t2l.identify.least_squares import LeastSquares
from t2l.identify.levels import HALF, MATERIAL
from t2l.identify.optimiser import minimise
from t2l.identify.prediction import Predictor, Request

ITERATIONS = 5  # numerics: of a fit by simulation alone
CORRECTED = 2  # numerics: of one along the motion, which simulations correct
COARSENESS = (40, 20, 10, 5, 4, 2)  # numerics: control periods a tick that are tried
COARSEST = 5  # numerics: of a loop with periods that are not short
LONG_TICK_S = 1e-2  # numerics: likewise for a slow loop
MANY_TICKS = 24_000  # numerics: of recordings, of which more ask for longer ticks
SHORT_TICK_S = 2.5e-3  # numerics: in which the linear model of a loop is nearly exact
HOPELESS = 4.0  # numerics: times the least loss, at which a fit that gains little is given up


@dataclass(frozen=True)
class Samples:
    """What is fitted: the samples of a predictor, at fewer ticks for all but the last steps.

    Attributes:
        exact, draft: predictors of the same recordings.
        linear: likewise, at ticks that are short for a loop.
        mask: (nsample,) bool.
        folds: (nfitted, k) of the samples of `mask`, see `DataSplit`.
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
    before = dict(values)
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
            for parameter, joint in member.setting:
                if parameter == column.parameter and column.joint in (joint, None):
                    new[name, parameter, joint] += weights[at]
            at += 1
    whole = Layout([Term(effects[name], tuple(sorted(of))) for name, of in joints.items()])
    start, unmoved = (
        np.array([known[s.key] if s.key in known else new[s.key] for s in whole.slots])
        for known in (values, before)
    )
    start, unmoved = (np.clip(u, whole.lower, whole.upper) for u in (start, unmoved))
    return Start(whole, start, unmoved=None if values == before else unmoved)


def fit_sets(
    starts: Sequence[Start],
    samples: Samples,
    along: AlongMotion | None = None,
    known: Known | None = None,
    iterations: int | None = None,
) -> list[FittedSet]:
    """Fit layouts from their starts, on the draft; those that run away are left out.

    Args:
        along: corrected by simulations it gives their steps and derivatives; None if these are by
            simulation.
        known: a model, and what it leaves of the fitted samples on every tick.
        iterations: of each, if not as many as usual.
    """
    shift = 0.0
    if known is not None and samples.draft is not samples.exact:
        (layout, u), residual = known
        coarse = samples.draft.predict([Request(layout, u[None])])[0][0][samples.mask]
        shift = coarse - (residual + samples.draft.samples.q[samples.mask])
    objective = _Shifted(samples.draft, samples.mask, shift)
    return _fitted(starts, samples, objective, along, iterations, settling=True)


def finish(
    sets: Sequence[FittedSet], samples: Samples, along: AlongMotion | None = None
) -> list[FittedSet]:
    """The same on every tick."""
    if samples.draft is samples.exact:
        return [*sets]
    starts = [Start(one.layout, one.u, one.columns, one.beyond) for one in sets]
    objective = Positions(samples.exact, samples.mask)
    return _fitted(starts, samples, objective, along)


def _fitted(
    starts: Sequence[Start],
    samples: Samples,
    objective: Positions,
    along: AlongMotion | None,
    iterations: int | None = None,
    settling: bool = False,
) -> list[FittedSet]:
    if iterations is None:
        iterations = CORRECTED if along is not None else ITERATIONS
    if along is not None:
        return fit_corrected(
            starts, along, objective, samples.folds, iterations, _give_up, settling
        )
    fits = [
        LeastSquares(
            start.layout, start.u.copy(), sizes(start), given=dict(start.columns),
            secant=bool(start.columns), noise=samples.noise_rad,
            last=None if start.columns else iterations,
        )
        for start in starts
    ]  # fmt: skip
    minimise(fits, objective, iterations, _give_up)
    return fitted(fits, objective, samples.folds)


def _give_up(fits: Sequence) -> None:
    """End those that leave much more than the best and gain little."""
    least = min((fit.loss for fit in fits), default=0.0)
    for fit in fits:
        # numerics: a round that gains less is near its end
        if fit.iterations >= 2 and fit.loss > HOPELESS * least and fit.gain < 0.3:
            fit.done = True
