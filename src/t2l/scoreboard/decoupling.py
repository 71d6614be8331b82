"""Claims that the stiffness of a task is not that of its controller."""

import numpy as np

from t2l.published.numbers import Published
from t2l.scoreboard.claim import Claim
from t2l.scoreboard.evidence import AbsentError, Evidence
from t2l.scoreboard.words import among
from t2l.stats.bootstrap import ratio
from t2l.stats.verdict import Finding, greater, within

COLUMNS = ("behaviour", "seed", "update", "stiffness_n_per_m")
WITHIN = 2.0  # a factor, for the study's "about"


def _last(evidence: Evidence) -> tuple[np.ndarray, np.ndarray]:
    """Effective stiffness (N/m) of each training seed at its end: stiff, compliant behaviour."""
    table = evidence.table("stiffness", COLUMNS)
    groups = []
    for behaviour in ("stiff", "compliant"):
        own = table[table.behaviour == behaviour]
        if own.empty:
            raise AbsentError(f"no policy of {behaviour} behaviour")
        final = own[own["update"] == own.groupby("seed")["update"].transform("max")]
        groups.append(final.groupby("seed").stiffness_n_per_m.median().to_numpy())
    return groups[0], groups[1]


def _stiffer(evidence: Evidence, published: Published, tests: int) -> Finding:
    stiff, compliant = _last(evidence)
    found = greater(stiff, compliant, tests=tests)
    return among(found, "{:.0f} and {:.0f} N/m", stiff, compliant)


def _ratio(evidence: Evidence, published: Published, tests: int) -> Finding:
    stiff, compliant = _last(evidence)
    about = published.values["ratio"]
    found = within(ratio, stiff, compliant, low=about / WITHIN, high=about * WITHIN)
    return among(found, "{:.1f} times", [float(ratio(stiff, compliant))])


CLAIMS = [
    Claim(
        "stiff_behaviour",
        "A soft arm can learn to be stiffer in its task than a stiff arm that learned to yield.",
        "training seed",
        "effective stiffness at the end of training, one-sided Mann-Whitney",
        "the soft arm is not the stiffer",
        _stiffer,
    ),
    Claim(
        "stiffness_ratio",
        "It becomes about five times stiffer.",
        "training seed",
        "the ratio of geometric means lies between 2.5 and 10, by its bootstrap interval",
        judge=_ratio,
    ),
]
