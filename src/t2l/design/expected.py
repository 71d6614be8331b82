"""How well motions determine effects: expected errors, and pairs that look alike."""

from dataclasses import dataclass
from typing import Any

import numpy as np

# statistics: of the plausible size: an estimate as uncertain as that says nothing
UNTOLD = 1.0
HIDDEN = 1.0  # statistics: of the noise: a difference that is smaller in RMS cannot be seen


@dataclass(frozen=True)
class Expected:
    """How well a parameter will be known.

    Attributes:
        joint: its name; None for a parameter of the robot.
        value: plausible; `plausible_change` what counts as large, both in `unit`.
        error: expected standard error if no other effect is looked for; infinite if never told.
        error_together: likewise, if all effects are looked for at once.
    """

    effect: str
    title: str
    parameter: str
    joint: str | None
    unit: str
    value: float
    plausible_change: float
    error: float
    error_together: float

    @property
    def told(self) -> bool:
        """Whether its effect alone could be told from nothing."""
        return self.error < UNTOLD * self.plausible_change

    @property
    def told_together(self) -> bool:
        """Whether it can be told with all the others unknown."""
        return self.error_together < UNTOLD * self.plausible_change

    @property
    def words(self) -> str:
        """What it is."""
        where = "" if self.joint is None else f" of {self.joint}"
        return (
            f"{self.title}: {self.parameter}{where}" if self.parameter else f"{self.title}{where}"
        )


@dataclass(frozen=True)
class Confounded:
    """Two effects of which one imitates the other on a joint.

    Attributes:
        first: whose response is imitated; by `second`.
        joint: where most.
        correlation: of the response of `first` with the nearest that `second` can make.
        difference: RMS between the two, over the noise.
    """

    first: str
    second: str
    joint: str
    correlation: float
    difference: float

    @property
    def hidden(self) -> bool:
        """Whether the noise hides which of the two it is."""
        return self.difference < HIDDEN


@dataclass(frozen=True)
class Identifiability:
    """What some motions tell.

    Attributes:
        looked_at: how many recordings; `of` so many.
    """

    expected: list[Expected]
    confounded: list[Confounded]
    noise_rad: float
    looked_at: int
    of: int

    @property
    def untold(self) -> list[Expected]:
        """Parameters that cannot be told."""
        return [entry for entry in self.expected if not entry.told]

    def sentences(self, what: str) -> list[str]:
        """What `what`, such as "this log", cannot tell; empty if it tells all.

        One sentence for each parameter of an effect, with its joints, and one for each pair.
        """
        where: dict[tuple[str, str], list[str]] = {}
        for entry in self.untold:
            where.setdefault((entry.title, entry.parameter), []).append(entry.joint or "")
        said = []
        for (title, parameter), joints in where.items():
            named = f"{title} ({parameter})" if parameter else title
            on = f" of {', '.join(joints)}" if any(joints) else ""
            said.append(f"{what} cannot tell {named}{on}")
        said += [
            f"{what} cannot tell {pair.first} from {pair.second} (most alike on {pair.joint}, "
            f"correlation {pair.correlation:.3f})"
            for pair in self.confounded
            if pair.hidden
        ]
        return said

    def as_json(self) -> dict[str, Any]:
        """Plain values; None for an error without bound."""
        return {
            "noise_rad": self.noise_rad,
            "recordings": {"looked_at": self.looked_at, "of": self.of},
            "parameters": [
                {
                    "effect": e.effect, "parameter": e.parameter, "joint": e.joint, "unit": e.unit,
                    "plausible_value": e.value, "plausible_change": e.plausible_change,
                    "expected_error": _finite(e.error),
                    "expected_error_together": _finite(e.error_together),
                    "told": bool(e.told), "told_together": bool(e.told_together),
                }
                for e in self.expected
            ],
            "confounded": [
                {
                    "effect": c.first, "looks_like": c.second, "joint": c.joint,
                    "correlation": c.correlation, "difference_over_noise": c.difference,
                    "told": not c.hidden,
                }
                for c in self.confounded
            ],
        }  # fmt: skip


def _finite(value: float) -> float | None:
    return float(value) if np.isfinite(value) else None
