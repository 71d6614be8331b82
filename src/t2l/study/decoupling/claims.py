"""Claims that the stiffness of a task is not that of its controller."""

from collections.abc import Callable

import numpy as np
import pandas as pd

from t2l.stats.bootstrap import ratio
from t2l.stats.verdict import Finding, greater, within
from t2l.study.claim import Claim
from t2l.study.decoupling.summary import HELD, STEADY, chosen, holding
from t2l.study.evidence import AbsentError, Evidence
from t2l.study.published.numbers import Published
from t2l.study.words import among, cannot_tell

COLUMNS = ("pairing", "kp", "seed", "stiffness_n_m", "drift", "success")
WITHIN = 2.0  # a factor, for the study's "about"
FORM = "{:.0f} and {:.0f} N/m"


def _last(trainings: pd.DataFrame) -> tuple[np.ndarray, np.ndarray]:
    """Effective stiffness (N/m) of each training seed at its end: of the soft arm, the stiff one.

    The soft arm, with the lower Kp, learned to be stiff, and the other way round.
    """
    if trainings.kp.nunique() < 2:
        raise AbsentError("one arm only")
    soft, hard = (
        trainings[trainings.kp == kp].groupby("seed").stiffness_n_m.median().to_numpy()
        for kp in (trainings.kp.min(), trainings.kp.max())
    )
    return soft, hard


def _judged(decide: Callable[[np.ndarray, np.ndarray], Finding], evidence: Evidence) -> Finding:
    """A finding of trainings that hold their pose steadily; if one does not, it cannot be told."""
    trainings = chosen(evidence.table("stiffness", COLUMNS))
    found = decide(*_last(trainings))
    if holding(trainings).all():
        return found
    steady = int((trainings.drift <= STEADY).sum())
    why = f"of {found.n} policies {steady} yield steadily"
    if trainings.success.notna().all():
        why += f", {int((trainings.success >= HELD).sum())} hold the pose"
    return cannot_tell(found, why)


def _stiffer(evidence: Evidence, published: Published, tests: int) -> Finding:
    def decide(soft: np.ndarray, hard: np.ndarray) -> Finding:
        return among(greater(soft, hard, tests=tests), FORM, soft, hard)

    return _judged(decide, evidence)


def _ratio(evidence: Evidence, published: Published, tests: int) -> Finding:
    about = published.values["ratio"]

    def decide(soft: np.ndarray, hard: np.ndarray) -> Finding:
        found = within(ratio, soft, hard, low=about / WITHIN, high=about * WITHIN)
        span = f" ({found.lower:.1f} to {found.upper:.1f})"
        return among(found, "{:.1f} times" + span, [float(ratio(soft, hard))])

    return _judged(decide, evidence)


# where several weights were tried for one gain, `chosen` says which counts
TOLD_OF = (
    "; told only of trainings that all hold their pose (in half of their episodes) and yield "
    "steadily (of two opposite pushes half the difference, averaged over the second half of a "
    "push; the mean over either half of that differs from it by at most a tenth)"
)
CLAIMS = [
    Claim(
        "stiff_behaviour",
        "A soft arm can learn to be stiffer in its task than a stiff arm that learned to yield.",
        "training seed",
        f"effective stiffness at the end of training, one-sided Mann-Whitney{TOLD_OF}",
        "the soft arm is not the stiffer",
        _stiffer,
        about="decoupling_swept",
    ),
    Claim(
        "stiffness_ratio",
        "It becomes about five times stiffer.",
        "training seed",
        f"the ratio of geometric means lies between 2.5 and 10, by its bootstrap interval{TOLD_OF}",
        judge=_ratio,
        about="decoupling_swept",
    ),
]
