"""Which joints, under which conditions, hold most of the squared error; said in sentences."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from t2l.diagnose.conditions import UNITS
from t2l.identify.levels import AT_THE_FLOOR, HALF, MATERIAL
from t2l.identify.prediction import Predictor
from t2l.names import with_minus

LEAST_SHARE = MATERIAL  # of the squared error; less is not worth a sentence
# derived: share of the squared error over share of the samples, within the joint
LEAST_LIFT = AT_THE_FLOOR**2
ALIKE = HALF  # overlap of two findings' squared error from which the lesser is left out
QUANTILES = (0.1, 0.2, 0.35, 0.5, 0.65, 0.8, 0.9)  # numerics: near which round thresholds are tried

# conditions that are split by their size: how the sentence goes on
SIZES = {
    "velocity": ("below {}", "above {}"),
    "acceleration": ("with acceleration below {}", "with acceleration above {}"),
    "torque": ("with commanded torque below {}", "with commanded torque above {}"),
    "torque rate": (
        "with commanded torque changing slower than {}",
        "with commanded torque changing faster than {}",
    ),
    "gravity": ("with gravity load below {}", "with gravity load above {}"),
    "command velocity": (
        "while the command is slower than {}",
        "while the command is faster than {}",
    ),
}
# conditions that say much the same: a joint gets one sentence of each line
FAMILIES = (
    ("velocity", "acceleration", "torque rate", "command velocity"),
    ("torque", "gravity"),
)
SIGNS = {
    "direction": ("moving in the positive direction", "moving in the negative direction"),
    "torque": ("with positive commanded torque", "with negative commanded torque"),
    "gravity": ("with positive gravity load", "with negative gravity load"),
}
REST = "at rest"


@dataclass(frozen=True)
class Finding:
    """A joint under a condition, and what part of the error arises there.

    Attributes:
        joint: its name.
        condition: one of `t2l.diagnose.conditions`, "stiffness", or "" for all of the joint.
        where: the condition as text, such as "below 0.1 rad/s".
        share: of the total squared error.
        samples: fraction of all samples.
        rmse_rad: of the error there.
    """

    joint: str
    condition: str
    where: str
    share: float
    samples: float
    rmse_rad: float

    @property
    def sentence(self) -> str:
        """For people: "62 % of the squared error is elbow below 0.1 rad/s, in 18 % of ..."."""
        where = f" {self.where}" if self.where else ""
        return (
            f"{percent(self.share)} of the squared error is {self.joint}{where}, in "
            f"{percent(self.samples)} of the samples"
        )


def findings(
    predictor: Predictor,
    residual: np.ndarray,
    features: Mapping[str, np.ndarray],
    top: int = 8,  # format: sentences
) -> list[Finding]:
    """Joints and conditions that hold more of the squared error than of the samples.

    They are ranked by share · ln(share of the error / share of the samples): much of the error in
    few samples. Of findings about much the same samples only the first is kept.

    Args:
        residual: (nsample,) measured minus predicted, rad.
        features: as `t2l.diagnose.conditions.features` gives them.
        top: how many at most.
    """
    square, total = residual**2, float(np.sum(residual**2))
    if not total > 0:
        return []
    ranked = []
    for joint, name in enumerate(predictor.joints):
        held = np.flatnonzero(predictor.samples.joint == joint)
        if not len(held) or square[held].sum() < LEAST_SHARE * total:
            continue
        own = square[held].sum() / total
        candidates = [("", "", np.ones(len(held), bool))]
        candidates += _by_feature({key: values[held] for key, values in features.items()})
        candidates += _by_stiffness(predictor, held, joint)
        for condition, where, inside in candidates:
            share, part = float(square[held[inside]].sum() / total), inside.mean()
            if share < LEAST_SHARE or inside.sum() < 2:
                continue
            if condition and share / own < LEAST_LIFT * part:
                continue
            fraction = float(inside.sum() / len(residual))
            rmse = float(np.sqrt(square[held[inside]].mean()))
            found = Finding(name, condition, where, share, fraction, rmse)
            ranked.append((share * np.log(share / fraction), found, held[inside]))
    ranked.sort(key=lambda entry: -entry[0])
    kept: list[tuple[Finding, np.ndarray]] = []
    for score, found, at in ranked:
        told = any(
            _family(found) == _family(other) or _overlap(square, at, there) > ALIKE
            for other, there in kept
        )
        if score > 0 and not told:
            kept.append((found, at))
        if len(kept) == top:
            break
    return [found for found, _ in kept]


def _family(found: Finding) -> tuple[str, tuple[str, ...]]:
    alone = (found.condition,)
    return found.joint, next((f for f in FAMILIES if found.condition in f), alone)


def _overlap(square: np.ndarray, first: np.ndarray, second: np.ndarray) -> float:
    """Squared error that two sets of samples share, over that of both together."""
    common = square[np.intersect1d(first, second, assume_unique=True)].sum()
    return float(common / (square[first].sum() + square[second].sum() - common))


Candidate = tuple[str, str, np.ndarray]


def _by_feature(features: Mapping[str, np.ndarray]) -> Iterator[Candidate]:
    for condition, (below, above) in SIZES.items():
        size, unit = np.abs(features[condition]), UNITS[condition]
        for bound in round_thresholds(size):
            yield condition, below.format(f"{bound:g} {unit}"), size < bound
            yield condition, above.format(f"{bound:g} {unit}"), size >= bound
    for condition, (positive, negative) in SIGNS.items():
        values = features[condition]
        if (values > 0).any() and (values < 0).any():
            yield condition, positive, values > 0
            yield condition, negative, values < 0
    yield "direction", REST, features["direction"] == 0
    for condition, text in (
        (
            "position",
            ("at positions below {1}", "at positions {0} to {1}", "at positions above {0}"),
        ),
        ("time", ("in the first {1}", "from {0} to {1}", "after {0}")),
    ):
        yield from _thirds(condition, features[condition], text)


def _thirds(condition: str, values: np.ndarray, texts: Sequence[str]) -> Iterator[Candidate]:
    low, high = values.min(), values.max()
    if not high > low:
        return
    first, second = (_rounded(low + part * (high - low), high - low) for part in (1 / 3, 2 / 3))
    names = [with_minus(f"{bound:g} {UNITS[condition]}") for bound in (first, second)]
    parts = (values < first, (values >= first) & (values < second), values >= second)
    bounds = ((None, names[0]), names, (names[1], None))
    for inside, text, ends in zip(parts, texts, bounds, strict=True):
        yield condition, text.format(*ends), inside


def _by_stiffness(predictor: Predictor, held: np.ndarray, joint: int) -> Iterator[Candidate]:
    kp = np.array([r.kp[joint] for r in predictor.recordings])
    gains = np.unique(kp)
    at = kp[predictor.samples.recording[held]]
    for gain in gains[:-1]:
        text = f"at Kp {gain:g}" if gain == gains[0] else f"at Kp {gain:g} and below"
        yield "stiffness", text, at <= gain
    for gain in gains[1:]:
        text = f"at Kp {gain:g}" if gain == gains[-1] else f"at Kp {gain:g} and above"
        yield "stiffness", text, at >= gain


def round_thresholds(size: np.ndarray) -> list[float]:
    """Numbers 1, 2 or 5 times a power of ten near the quantiles of sizes (n,)."""
    quantiles = np.quantile(size, QUANTILES)
    quantiles = quantiles[quantiles > 1e-6 * max(size.max(initial=0.0), 1e-12)]
    if not len(quantiles):
        return []
    decade = np.floor(np.log10(quantiles))
    choices = np.array([1.0, 2.0, 5.0, 10.0])  # format: round numbers
    nearest = np.abs(np.log(quantiles / 10**decade)[:, None] - np.log(choices)).argmin(axis=1)
    # through text: 0.30000000000000004 is not round
    return sorted(
        {float(f"{choices[i] * 10**d:.1g}") for i, d in zip(nearest, decade, strict=True)}
    )


def _rounded(value: float, span: float) -> float:
    """`value` to two digits of `span`."""
    digits = 1 - int(np.floor(np.log10(span)))
    return float(f"{np.round(value, digits):.6g}") + 0.0


def percent(fraction: float) -> str:
    """A fraction in per cent, with one digit of what is below one."""
    # format: digits
    return f"{100 * fraction:.0f} %" if abs(fraction) >= 0.01 else f"{100 * fraction:.1g} %"
