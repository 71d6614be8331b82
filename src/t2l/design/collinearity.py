"""Which responses others can be in the place of: near collinearity of small sets of effects.

The responses to an effect's parameters span a space. A response that lies nearly in the space of
another effect, or of two together, is one that their parameters make as well: no recording like
these tells which it was. How nearly is the collinearity index γ = 1/√(1 − ρ²), with ρ the cosine of
the angle between the response and that space (Brun et al., Practical identifiability analysis of
large environmental simulation models, Water Resources Research 37, 2001, here of one response
against a set). What a model has already is fitted along: all is taken off that its parameters can
do (partial regression, Frisch and Waugh, 1933).
"""

from collections.abc import Mapping, Sequence
from collections.abc import Set as AbstractSet
from dataclasses import dataclass
from itertools import combinations

import numpy as np

# statistics: index from which a set is hardly identifiable, of the 5 to 20 that Brun et al. found
COLLINEAR = 10.0
RIDGE = 1e-9  # numerics: of a column's square: keeps what columns share at a finite coefficient
VANISHED = 1e-6  # numerics: of a column's size: what is left where the model can do all of it


@dataclass(frozen=True)
class Rival:
    """One or two effects that do what another one does.

    Attributes:
        effects: their names.
        collinearity: index γ of the other's response with what they can do; None where they were
            simulated in its place.
        error: RMS left with them in its place.
    """

    effects: tuple[str, ...]
    collinearity: float | None
    error: float


class Responses:
    """Columns of sensitivities by effect, less what a model's own parameters can do."""

    def __init__(
        self,
        columns: np.ndarray,
        names: Sequence[str],
        base: np.ndarray,
        excludes: Mapping[str, AbstractSet[str]],
    ):
        """Products of the columns are all that is looked at later.

        Args:
            columns: (nsample, k); `names` (k,) the effect of each.
            base: (nsample, b) columns of the model's own parameters.
            excludes: by name, effects that are no rivals: it contains them, or they contain it.
        """
        self._basis = _basis(base)
        left = self.free(columns)
        size, before = _rms(left), _rms(columns)
        kept = np.flatnonzero(size > VANISHED * np.maximum(before, np.finfo(float).tiny))
        self.columns = left[:, kept] / size[kept]
        of = np.array(names)[kept]
        self.index = {name: np.flatnonzero(of == name) for name in dict.fromkeys(of.tolist())}
        self.excludes = excludes
        self._gram = self.columns.T @ self.columns / len(columns)

    def free(self, response: np.ndarray) -> np.ndarray:
        """(nsample, …) what the model's own parameters cannot do of it."""
        return response - self._basis @ (self._basis.T @ response)

    def part(self, name: str, target: np.ndarray) -> np.ndarray:
        """(nsample,) the nearest that an effect can come to a target (nsample,)."""
        at = self.index[name]
        return self.columns[:, at] @ self._weights(at, self.columns.T @ target / len(target))

    def rivals(self, name: str, part: np.ndarray, target: np.ndarray, most: float) -> list[Rival]:
        """Effects, or pairs of which neither does alone, that do what an effect does.

        Their collinearity with its response is at least `COLLINEAR`.

        Args:
            part: (nsample,) response to the effect.
            target: (nsample,) what it is to explain a part of.
            most: RMS that they may leave of the target.
        """
        part, target = self.free(part), self.free(target)
        shared = self.columns.T @ np.stack([part, target], axis=1) / len(part)
        square = np.array([np.mean(part**2), np.mean(target**2)])
        limit = np.array([square[0] / COLLINEAR**2, most**2])
        others = [n for n in self.index if n != name and n not in self.excludes.get(name, ())]
        found, single = [], set()
        for effects in [*((n,) for n in others), *combinations(others, 2)]:
            first, *more = effects
            if more and (single & set(effects) or more[0] in self.excludes.get(first, ())):
                continue
            left = self._left(np.concatenate([self.index[n] for n in effects]), shared, square)
            if (left <= limit).all():
                single |= set(effects) if not more else set()
                index = np.sqrt(square[0] / max(left[0], np.finfo(float).tiny))
                found.append(Rival(effects, float(index), float(np.sqrt(max(left[1], 0.0)))))
        return sorted(found, key=lambda rival: (len(rival.effects), -rival.collinearity))

    def _left(self, at: np.ndarray, shared: np.ndarray, square: np.ndarray) -> np.ndarray:
        return square - np.sum(shared[at] * self._weights(at, shared), axis=0)

    def _weights(self, at: np.ndarray, shared: np.ndarray) -> np.ndarray:
        return np.linalg.solve(self._gram[np.ix_(at, at)] + RIDGE * np.eye(len(at)), shared[at])


def _rms(columns: np.ndarray) -> np.ndarray:
    return np.sqrt(np.mean(columns**2, axis=0))


def _basis(columns: np.ndarray) -> np.ndarray:
    """Orthonormal columns (nsample, r) of the same space."""
    size = _rms(columns)
    scaled = columns[:, size > 0] / size[size > 0]
    u, values, _ = np.linalg.svd(scaled, full_matrices=False)
    return u[:, values > VANISHED * values.max(initial=0.0)]
