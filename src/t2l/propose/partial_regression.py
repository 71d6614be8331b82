"""What the parameters of a model take up of a residual, and of the responses to another law.

What is left of both is regressed (Frisch and Waugh, 1933; Lovell, 1963): its weights are those of a
fit of all together, as in orthogonal matching pursuit. Without it a law would have to explain what
is left while the laws before it stand still, and two that only together make sense are not found.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from t2l.propose.refit import State
from t2l.propose.ridge import least_ridge


@dataclass(frozen=True)
class PartialRegression:
    """A penalised linear fit of a state's parameters, to be made beside another law.

    Rows of the results are the samples, and below them the penalties of the state's own laws.

    Attributes:
        columns: (nsample, m) change of position by each parameter.
        rows: (p, m) of the penalties.
        u: (m,) the parameters.
        fitted: (nsample,) bool.
    """

    columns: np.ndarray
    rows: np.ndarray
    u: np.ndarray
    fitted: np.ndarray

    @classmethod
    def at(
        cls, state: State, columns: Mapping[tuple, np.ndarray], fitted: np.ndarray
    ) -> "PartialRegression":
        """At a state, with `columns` (nsample,) of its Jacobian by slot key."""
        parts = [columns[slot.key] for slot in state.layout.slots]
        stacked = np.stack(parts, axis=1) if parts else np.zeros((len(fitted), 0))
        return cls(stacked, state.rows(), state.u, fitted)

    def left_of(self, residual: np.ndarray) -> np.ndarray:
        """(nsample + p,) of a residual (nsample,), what the parameters leave."""
        below = -self.rows @ self.u
        change = self._fit(residual, below)
        return np.concatenate([residual - self.columns @ change, below - self.rows @ change])

    def left_of_responses(self, responses: np.ndarray) -> np.ndarray:
        """(nsample + p, k) of the responses (nsample, k) to a law, what the parameters leave."""
        change = self._fit(responses, np.zeros((len(self.rows), responses.shape[1])))
        return np.concatenate([responses - self.columns @ change, -self.rows @ change])

    def masks(self, chosen: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Which rows are fitted, and which choose; penalties are fitted."""
        below = np.ones(len(self.rows), bool)
        return np.concatenate([self.fitted, below]), np.concatenate([chosen, ~below])

    def _fit(self, target: np.ndarray, below: np.ndarray) -> np.ndarray:
        inside = self.columns[self.fitted]
        normal = inside.T @ inside + self.rows.T @ self.rows
        normal += least_ridge(normal)
        return np.linalg.solve(normal, inside.T @ target[self.fitted] + self.rows.T @ below)
