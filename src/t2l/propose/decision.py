"""When a known effect may be named, and when a learned curve says more.

A known effect is named if it leaves at most `NEAR` times what the best law in its place leaves, or
times the noise where that is more. Otherwise a law of one variable explains clearly more than it,
and a name would mislead.

That no law does better is no proof: what is missing may follow no single variable. So names are
adopted only if the model goes at least half of the way, in orders of magnitude, from the error as
it came down to the noise. A name that stands in for something else takes away what the two have in
common, and so leaves a share of the error. A right name leaves what does not grow with the effect:
noise, and the flaws of the log. The geometric mean is equally far from either end. Of several
names each must go half of the way that those before it left: with enough numbers, wrong ones come
near the noise too.
"""

from dataclasses import dataclass

from t2l.identify.levels import AT_THE_FLOOR

NEAR = AT_THE_FLOOR  # as near as an error must be to the noise to count as noise


@dataclass(frozen=True)
class Decision:
    """Whether a known effect is named, and the part of the squared error it explains.

    Attributes:
        fraction: of what the best law explains; more than one is one.
    """

    named: bool
    fraction: float


def decide(known: float, ceiling: float, baseline: float, noise: float) -> Decision:
    """Judge a known effect by RMS errors on the same samples, rad.

    Args:
        known: with the effect.
        ceiling: with the best law in its place.
        baseline: with neither.
        noise: of a perfect model.

    Raises:
        ValueError: an error is not finite or negative.
    """
    for name, value in (
        ("known", known), ("ceiling", ceiling), ("baseline", baseline), ("noise", noise),
    ):  # fmt: skip
        if not 0 <= value < float("inf"):
            raise ValueError(f"{name}: found {value}; allowed: a finite RMS error, not negative")
    possible = baseline**2 - min(ceiling, known) ** 2
    explained = baseline**2 - known**2
    fraction = 0.0 if possible <= 0 else min(max(explained / possible, 0.0), 1.0)
    return Decision(known <= NEAR * max(ceiling, noise), fraction)


def each_goes_half_way(count: int, left: float, came: float, noise: float) -> bool:
    """Whether effects or laws go half of the way to the noise, by RMS errors on the same samples.

    Args:
        count: how many they are.
        left: with all of them.
        came: with none of them.
        noise: of a perfect model.
    """
    share = 0.5**count
    return left <= max(noise ** (1 - share) * came**share, NEAR * noise)
