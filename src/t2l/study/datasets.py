"""Claims about recordings that other people made: how closely robots follow their commands."""

import numpy as np

from t2l.response.following import most
from t2l.stats.verdict import Finding, paired_greater
from t2l.study.claim import Claim
from t2l.study.evidence import AbsentError, Evidence
from t2l.study.published.numbers import Published
from t2l.study.words import cannot_tell

COLUMNS = ("dataset", "commands", "gains", "learning", "follows")
# whose gains people chose to work with, and whose commands were logged, not made from torques
SENT, CHOSEN = "as sent", "one pair"


def _follow(evidence: Evidence, published: Published, tests: int) -> Finding:
    table = evidence.table("following", COLUMNS)
    usable = table[(table.commands == SENT) & (table.gains == CHOSEN)]
    if usable.empty:
        raise AbsentError("no data set with commands as sent and gains that were not varied")
    learning = usable.groupby("dataset").learning.all()
    follow = usable.groupby("dataset").follows.agg(
        lambda joints: most([None if joint == "not told" else joint == "yes" for joint in joints])
    )
    told = follow[follow.notna()].astype(bool)
    counted = told[learning[told.index]]
    found = paired_greater(np.where(counted, 1.0, -1.0), tests=tests)
    others = told[~learning[told.index]]
    if not len(counted):
        ours = f"of {len(others)} robots recorded to be identified {int(others.sum())} follow"
        return cannot_tell(
            Finding(found.verdict, len(others), ours=ours), "no data set for learning"
        )
    ours = f"{int(counted.sum())} of {len(counted)}"
    return Finding(found.verdict, len(counted), found.value, p=found.p, ours=ours)


CLAIMS = [
    Claim(
        "stiff_datasets",
        "Large public data sets were recorded with stiff gains.",
        "data set",
        "more than half of the data sets for learning follow their commands closely, one-sided "
        "sign test; a data set does if more than half of its joints do; a joint does if, by their "
        "95 % intervals, its lag is at most 1/15 s and its damping ratio at least 0.69 (5 % "
        "overshoot). Only of commands logged as they were sent, and of gains that were not varied",
        "half of them or fewer follow closely",
        _follow,
    ),
]
