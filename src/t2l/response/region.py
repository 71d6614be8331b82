"""Which of the study's four regions of gains a joint lies in, as far as its motion tells.

Motion shows ω_n = √(Kp/M), not Kp: a joint is called stiff where ω_n is at least `stiff_from_hz`,
and overdamped where ζ is at least 1. Two letters: C or S (compliant, stiff), then U or O.
"""

from dataclasses import dataclass

import numpy as np
from scipy.stats import norm

# hertz. A convention: a loop slower than this does not keep up with a person's arm
STIFF_FROM_HZ = 2.0
REGIONS = ("CO", "SO", "CU", "SU")
CERTAIN = 0.95
GRID = 2000


@dataclass(frozen=True)
class Region:
    """The likeliest region, and how likely each is by the uncertainty of ω_n and ζ."""

    name: str
    probability: dict[str, float]

    @property
    def certain(self) -> bool:
        """Whether it is the right one at 95 %."""
        return self.probability[self.name] >= CERTAIN


def region(
    omega: float, zeta: float, covariance: np.ndarray, stiff_from_hz: float = STIFF_FROM_HZ
) -> Region:
    """Of ω_n (rad/s) and ζ, with the covariance (2, 2) of their logarithms, taken as normal."""
    at = np.array([np.log(2 * np.pi * stiff_from_hz / omega), -np.log(zeta)])
    if not np.isfinite(covariance).all():
        even = dict.fromkeys(REGIONS, 0.25)
        return Region(_name(*(at <= 0)), even)
    spread = np.sqrt(np.diag(covariance)) + 1e-6
    z = at / spread
    together = np.clip(covariance[0, 1] / spread.prod(), -0.999, 0.999)
    # ζ given ω is normal too: averaged over ω at even steps of its probability
    drawn = norm.ppf((np.arange(GRID) + 0.5) / GRID)
    under = norm.cdf((z[1] - together * drawn) / np.sqrt(1 - together**2))
    compliant = drawn < z[0]
    probability = {
        "CO": float(np.mean(compliant * (1 - under))),
        "SO": float(np.mean(~compliant * (1 - under))),
        "CU": float(np.mean(compliant * under)),
        "SU": float(np.mean(~compliant * under)),
    }
    return Region(max(probability, key=probability.get), probability)


def _name(stiff: bool, over: bool) -> str:
    return ("S" if stiff else "C") + ("O" if over else "U")
