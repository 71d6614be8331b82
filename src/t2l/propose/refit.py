"""Laws and known effects fitted together through the simulation, by the one optimiser."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np

from t2l.effects.spline_torque import SplineTorque
from t2l.effects.term import Layout
from t2l.identify.fitting import ITERATIONS, REFINEMENTS, PositionError
from t2l.identify.least_squares import LeastSquares
from t2l.identify.optimiser import minimise
from t2l.identify.prediction import Predictor, Request
from t2l.propose.bases import penalty
from t2l.propose.dictionary import joined, moved, term_of, weights_in

COARSE = 4  # tuned: periods of the loop in a tick for all but the last steps of a fit
TOLERANCE = 0.01  # numerics: of the squared error: what is left is fitted again
# numerics: of a parameter's range: what makes a difference where its value is zero
LEAST_SIZE = 0.01
SCALES = (1.0, 0.5, 0.2)  # guess: of a linear guess, of which a fit begins at the best


@dataclass
class State:
    """Laws beside a model's own effects.

    Attributes:
        layout, u: of all of them.
        laws: that are fitted, each with the factor of its penalty.
    """

    layout: Layout
    u: np.ndarray
    laws: tuple[tuple[SplineTorque, float], ...] = ()

    def rows(self) -> np.ndarray:
        """(m, n): whose product with u is what the penalties add to the residuals."""
        parts = [np.zeros((0, len(self.u)))]
        for effect, factor in self.laws:
            own = np.zeros((len(penalty(effect)), len(self.u)))
            own[:, weights_in(self.layout, effect)] = np.sqrt(factor) * penalty(effect)
            parts.append(own)
        return np.concatenate(parts)


def without(state: State, names: Sequence[str]) -> State:
    """The state without some of its effects or laws."""
    kept = [term for term in state.layout.terms if term.effect.name not in names]
    layout = type(state.layout)(kept)
    laws = tuple(law for law in state.laws if law[0].name not in names)
    return State(layout, moved(state.layout, state.u, layout), laws)


def with_law(
    state: State,
    effect: SplineTorque,
    weights: np.ndarray,
    penalty_factor: float,
    joints: tuple[str, ...],
) -> State:
    """The state with one more law, the last, of given weights (k,)."""
    layout, u = joined(state.layout, state.u, [term_of(effect, joints)])
    u[weights_in(layout, effect)] = weights
    return State(layout, u, (*state.laws, (effect, penalty_factor)))


class PenalisedError(PositionError):
    """Position errors, and below them those of penalties; each fit has its own."""

    def __init__(
        self,
        predictor: Predictor,
        mask: np.ndarray,
        rows: dict[int, np.ndarray],
        shift: np.ndarray | float = 0.0,
    ):
        super().__init__(predictor, mask)
        self.measured = self.measured + shift
        self.rows = rows
        self.most = max((len(part) for part in rows.values()), default=0)
        self.joints = np.concatenate([self.joints, np.full(self.most, -1)])

    def residuals(self, asked):
        found = super().residuals(asked)
        whole = []
        for (optimiser, points), left in zip(asked, found, strict=True):
            rows = self.rows[id(optimiser)]
            extra = np.zeros((len(points), self.most))
            extra[:, : len(rows)] = points @ rows.T
            whole.append(np.concatenate([left, extra], axis=1))
        return whole

    def penalised(self, given: Mapping[tuple, np.ndarray], fit: LeastSquares) -> dict:
        """The `given` columns of a fit, with what the penalties add, which are linear."""
        extra = np.zeros((self.most, len(fit.u)))
        extra[: len(self.rows[id(fit)])] = self.rows[id(fit)]
        keys = enumerate(slot.key for slot in fit.layout.slots)
        return {key: np.concatenate([given[key], extra[:, i]]) for i, key in keys if key in given}


def columns(state: State, predictor: Predictor, mask: np.ndarray) -> dict[tuple, np.ndarray]:
    """Of the Jacobian of the positions at the samples of `mask`, by slot key, at a state."""
    bare = State(state.layout, state.u)
    (fit,) = refit([bare], predictor, mask, iterations=0)
    return fit.columns()


def refit(
    states: Sequence[State],
    predictor: Predictor,
    mask: np.ndarray,
    iterations: int = ITERATIONS,
    shift: np.ndarray | float = 0.0,
    given: Mapping[tuple, np.ndarray] = MappingProxyType({}),
    derivatives: bool = True,
) -> list[LeastSquares]:
    """Fit each state to the samples of `mask`, all in the same simulations; states get the end.

    Args:
        shift: rad, by which the predictor is off at the samples of the mask.
        given: columns of the Jacobian that are not computed anew, see `columns`.
        derivatives: whether they are wanted where the fits end; they cost a round's simulations.

    Returns:
        The fits, whose jacobian and residual have a row for each sample and then for penalties.
    """
    return _fitted(states, predictor, mask, iterations, shift, [given] * len(states), derivatives)


def finish(
    states: Sequence[State], begun: Sequence[LeastSquares], predictor: Predictor, mask: np.ndarray
) -> None:
    """Let states take the last steps, on finer ticks than the fits that brought them here.

    The steps are small, so that the derivatives on the coarse ticks serve.
    """
    count = mask.sum()
    given = [{key: column[:count] for key, column in fit.columns().items()} for fit in begun]
    _fitted(states, predictor, mask, REFINEMENTS, 0.0, given, derivatives=False)


def coarser(predictor: Predictor, state: State) -> Predictor:
    """The predictor with coarser ticks, where a state stands them."""
    coarse = predictor.of(predictor.recordings, COARSE)
    q = coarse.predict([Request(state.layout, state.u[None])])[0][0]
    return coarse if np.isfinite(q).all() else predictor


def off(coarse: Predictor, state: State, residual: np.ndarray) -> np.ndarray:
    """By how much a coarser predictor is off at every sample, rad.

    Args:
        residual: (nsample,) measured minus predicted, at the state on the finer ticks.
    """
    (q,) = coarse.predict([Request(state.layout, state.u[None])])
    return q[0] - coarse.samples.q + residual


def _fitted(
    states: Sequence[State],
    predictor: Predictor,
    mask: np.ndarray,
    iterations: int,
    shift: np.ndarray | float,
    given: Sequence[Mapping[tuple, np.ndarray]],
    derivatives: bool,
) -> list[LeastSquares]:
    fits = [_fit(state) for state in states]
    rows = {id(fit): state.rows() for fit, state in zip(fits, states, strict=True)}
    error = PenalisedError(predictor, mask, rows, shift)
    for fit, known in zip(fits, given, strict=True):
        fit.given = error.penalised(known, fit)
        fit.last = None if derivatives else iterations
    minimise(fits, error, iterations)
    for fit, state in zip(fits, states, strict=True):
        state.u = fit.u
    return fits


def begin_at_the_best(
    states: Sequence[State],
    predictor: Predictor,
    mask: np.ndarray,
    last: Sequence[SplineTorque],
    shift: np.ndarray | float = 0.0,
) -> None:
    """Let the law that each state got last begin at the best scale of its linear guess."""
    requests = []
    for state, effect in zip(states, last, strict=True):
        points = np.repeat(state.u[None], len(SCALES) + 1, axis=0)
        points[:, weights_in(state.layout, effect)] *= np.array([*SCALES, 0.0])[:, None]
        requests.append(Request(state.layout, points))
    measured = predictor.samples.q[mask] + shift
    for state, request, q in zip(states, requests, predictor.predict(requests), strict=True):
        loss = np.mean((q[:, mask] - measured) ** 2, axis=1)
        state.u = request.u[int(np.argmin(np.nan_to_num(loss, nan=np.inf)))]


def sizes(state: State) -> np.ndarray:
    """(n,) what makes a difference in each element of u."""
    layout, u = state.layout, state.u
    stated = np.array([slot.size for slot in layout.slots], float)
    span = LEAST_SIZE * np.where(layout.log, 1.0, layout.upper - layout.lower)
    return np.where(stated > 0, stated, np.where(u == 0, span, np.abs(u)))


def _fit(state: State) -> LeastSquares:
    return LeastSquares(state.layout, state.u.copy(), sizes(state), tolerance=TOLERANCE)
