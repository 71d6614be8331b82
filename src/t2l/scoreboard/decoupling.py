"""Claims that the stiffness of a task is not that of its controller."""

import numpy as np

from t2l.published.numbers import Published
from t2l.scoreboard.claim import Claim
from t2l.scoreboard.evidence import AbsentError, Evidence
from t2l.scoreboard.words import among
from t2l.stats.bootstrap import ratio
from t2l.stats.verdict import Finding, greater, within

COLUMNS = ("kp", "seed", "stiffness_n_m")
WITHIN = 2.0  # a factor, for the study's "about"


def _last(evidence: Evidence) -> tuple[np.ndarray, np.ndarray]:
    """Effective stiffness (N/m) of each training seed at its end: of the soft arm, the stiff one.

    The soft arm, with the lower Kp, learned to be stiff, and the other way round.
    """
    table = evidence.table("stiffness", COLUMNS)
    if table.kp.nunique() < 2:
        raise AbsentError("one arm only")
    soft, hard = (
        table[table.kp == kp].groupby("seed").stiffness_n_m.median().to_numpy()
        for kp in (table.kp.min(), table.kp.max())
    )
    return soft, hard


def _stiffer(evidence: Evidence, published: Published, tests: int) -> Finding:
    soft, hard = _last(evidence)
    found = greater(soft, hard, tests=tests)
    return among(found, "{:.0f} and {:.0f} N/m", soft, hard)


def _ratio(evidence: Evidence, published: Published, tests: int) -> Finding:
    soft, hard = _last(evidence)
    about = published.values["ratio"]
    found = within(ratio, soft, hard, low=about / WITHIN, high=about * WITHIN)
    return among(found, "{:.1f} times", [float(ratio(soft, hard))])


CLAIMS = [
    Claim(
        "stiff_behaviour",
        "A soft arm can learn to be stiffer in its task than a stiff arm that learned to yield.",
        "training seed",
        "effective stiffness at the end of training, one-sided Mann-Whitney",
        "the soft arm is not the stiffer",
        _stiffer,
        about="decoupling",
    ),
    Claim(
        "stiffness_ratio",
        "It becomes about five times stiffer.",
        "training seed",
        "the ratio of geometric means lies between 2.5 and 10, by its bootstrap interval",
        judge=_ratio,
        about="decoupling",
    ),
]
