"""Effects on chosen joints with their parameters as one vector, as an optimiser sees them."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from t2l.effects.effect import Effect, Parameter
from t2l.names import listed


@dataclass(frozen=True)
class Term:
    """An effect on some joints: (k,) indices into the recording's joints."""

    effect: Effect
    joints: tuple[int, ...]

    def width(self, parameter: Parameter) -> int:
        """How many numbers `parameter` has here."""
        return len(self.joints) if parameter.per_joint else 1

    def title(self, joints: Sequence[str]) -> str:
        """The effect's, with the joints that have it where not all `joints` of the robot do."""
        here = [joints[j] for j in self.joints]
        every = len(here) == len(joints) or self.effect.names_joints
        return self.effect.title if every else f"{self.effect.title} on {listed(here)}"


@dataclass(frozen=True)
class Slot:
    """One number of a parameter vector; `joint` is None for a parameter of the robot.

    `parameter` is in units.
    """

    term: Term
    parameter: Parameter
    joint: int | None

    @property
    def key(self) -> tuple[str, str, int | None]:
        """What it is in any layout: names of effect and parameter, and the joint."""
        return self.term.effect.name, self.parameter.name, self.joint

    @property
    def lower(self) -> float:
        """Bound of the fit."""
        return self._own(self.parameter.lower)

    @property
    def upper(self) -> float:
        """Bound of the fit."""
        return self._own(self.parameter.upper)

    @property
    def size(self) -> float:
        """A value that makes a difference; zero if the effect states none."""
        return self._own(self.parameter.size)

    @property
    def scale(self) -> float:
        """What its bounds are multiples of, one unit of the parameter if they are not."""
        return self._own(self.parameter.scale or 1.0)

    def _own(self, value: float | tuple[float, ...]) -> float:
        return value[self.joint or 0] if isinstance(value, tuple) else value


class Layout:
    """How the parameters of several terms lie in one vector u.

    u is the parameter itself, or its logarithm where `Parameter.log` says so.

    Attributes:
        slots: what each element of u is.
        lower, upper: (n,) bounds of u; infinite where effects state multiples of sizes unknown.
        neutral: (n,) u where the effects are absent, or the bound nearest to that; NaN if at none.
        rough, kinked: (n,) bool, elements without a useful derivative, or with kinks.
        prior: (m, n) rows of all effects' `Effect.prior`.
    """

    def __init__(self, terms: Sequence[Term]):
        self.terms = tuple(sorted(terms, key=lambda term: term.effect.order))
        self.slots = [
            Slot(term, parameter.in_units(), joint)
            for term in self.terms
            for parameter in term.effect.parameters
            for joint in (term.joints if parameter.per_joint else (None,))
        ]
        self.log = np.array([slot.parameter.log for slot in self.slots], bool)
        self.rough = np.array([slot.parameter.rough for slot in self.slots], bool)
        self.kinked = np.array([slot.parameter.kinked for slot in self.slots], bool)
        self.lower = self._scaled(np.array([slot.lower for slot in self.slots], float))
        self.upper = self._scaled(np.array([slot.upper for slot in self.slots], float))
        neutral = np.array([slot.parameter.neutral for slot in self.slots], float)
        self.neutral = np.clip(self._scaled(neutral), self.lower, self.upper)
        self.prior = self._prior()

    def __len__(self) -> int:
        return len(self.slots)

    def _scaled(self, theta: np.ndarray) -> np.ndarray:
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.where(self.log, np.log(np.where(self.log, theta, 1.0)), theta)

    def _prior(self) -> np.ndarray:
        rows = [np.zeros((0, len(self)))]
        for term in self.terms:
            own = term.effect.prior
            if own is None or not len(own):
                continue
            for joint in term.joints:
                at = [i for i, s in enumerate(self.slots) if s.term is term and s.joint == joint]
                whole = np.zeros((len(own), len(self)))
                whole[:, at] = own
                rows.append(whole)
        return np.concatenate(rows)

    def theta(self, u: np.ndarray) -> np.ndarray:
        """The parameters themselves, of the shape of u."""
        return np.where(self.log, np.exp(np.where(self.log, u, 0.0)), u)

    def encode(self, values: Mapping[str, Mapping[str, np.ndarray]]) -> np.ndarray:
        """u (n,) from ``values[effect][parameter]``, (k,) or (1,) each."""
        theta = np.concatenate(
            [
                np.broadcast_to(values[term.effect.name][p.name], term.width(p))
                for term in self.terms
                for p in term.effect.parameters
            ]
            or [np.zeros(0)]
        )
        return np.clip(self._scaled(theta), self.lower, self.upper)

    def decode(self, u: np.ndarray) -> dict[str, dict[str, np.ndarray]]:
        """``values[effect][parameter]`` (m, k) or (m, 1) from u (m, n)."""
        theta, values, at = self.theta(u), {}, 0
        for term in self.terms:
            values[term.effect.name] = {}
            for parameter in term.effect.parameters:
                width = term.width(parameter)
                values[term.effect.name][parameter.name] = theta[:, at : at + width]
                at += width
        return values
