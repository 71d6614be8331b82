"""Claims that the stiffness of a task is not that of its controller."""

from collections.abc import Callable

import numpy as np
import pandas as pd

from t2l.stats.bootstrap import ratio
from t2l.stats.verdict import Finding, Verdict, greater, within
from t2l.study.claim import Claim
from t2l.study.decoupling.summary import AT_REST, chosen, holding
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
    """A finding of trainings that hold their pose and rest; if one does not, it cannot be told."""
    trainings = chosen(evidence.table("stiffness", COLUMNS))
    soft, hard = _last(trainings)
    if holding(trainings).all():
        return decide(soft, hard)
    found = among(Finding(Verdict.CANNOT_TELL, len(trainings)), FORM, soft, hard)
    rest = int((trainings.drift <= AT_REST).sum())
    why = f"of {found.n} policies {rest} rest when measured"
    if trainings.success.notna().all():
        why += f", {int((trainings.success > 0).sum())} hold the pose"
    return cannot_tell(found, why)


def _stiffer(evidence: Evidence, published: Published, tests: int) -> Finding:
    def decide(soft: np.ndarray, hard: np.ndarray) -> Finding:
        return among(greater(soft, hard, tests=tests), FORM, soft, hard)

    return _judged(decide, evidence)


def _ratio(evidence: Evidence, published: Published, tests: int) -> Finding:
    about = published.values["ratio"]

    def decide(soft: np.ndarray, hard: np.ndarray) -> Finding:
        found = within(ratio, soft, hard, low=about / WITHIN, high=about * WITHIN)
        return among(found, "{:.1f} times", [float(ratio(soft, hard))])

    return _judged(decide, evidence)


# where several weights were tried for one gain, `chosen` says which counts
HELD = (
    "; told only of trainings that all hold their pose (success above 0) and rest when measured "
    "(the displacement changes by at most a tenth in its last half second)"
)
CLAIMS = [
    Claim(
        "stiff_behaviour",
        "A soft arm can learn to be stiffer in its task than a stiff arm that learned to yield.",
        "training seed",
        f"effective stiffness at the end of training, one-sided Mann-Whitney{HELD}",
        "the soft arm is not the stiffer",
        _stiffer,
        about="decoupling_swept",
    ),
    Claim(
        "stiffness_ratio",
        "It becomes about five times stiffer.",
        "training seed",
        f"the ratio of geometric means lies between 2.5 and 10, by its bootstrap interval{HELD}",
        judge=_ratio,
        about="decoupling_swept",
    ),
]
