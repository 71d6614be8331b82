"""The row on public data sets, by data sets that follow, that do not, and that are no such sets."""

import pandas as pd
import pytest

from t2l.stats.verdict import Verdict
from t2l.study.datasets import CLAIMS
from t2l.study.evidence import Evidence, source_of

SOURCE = source_of("results/recorded/following/joints.parquet")
MADE = {"commands": "made"}
VARIED = {"gains": "varied"}
IDENTIFIED = {"learning": False}


def finding(*datasets):
    """Of data sets: what each joint does, and what differs from a data set that counts."""
    rows = [
        {
            "dataset": str(i), "commands": "as sent", "gains": "one pair", "learning": True,
            **about, "follows": joint,
        }
        for i, (joints, about) in enumerate(datasets)
        for joint in joints
    ]  # fmt: skip
    return CLAIMS[0].finding(Evidence([(SOURCE, pd.DataFrame(rows))]))


FOLLOWS, LATE, OPEN = (["yes", "yes", "no"], {}), (["no", "no", "yes"], {}), (["not told"], {})


@pytest.mark.parametrize(
    ("datasets", "verdict", "n"),
    [
        ([FOLLOWS] * 5, Verdict.REPRODUCED, 5),
        ([FOLLOWS] * 5 + [OPEN], Verdict.REPRODUCED, 5),
        ([FOLLOWS] * 4, Verdict.CANNOT_TELL, 4),
        ([FOLLOWS] * 3 + [LATE] * 3, Verdict.NOT_REPRODUCED, 6),
        ([(["no"], IDENTIFIED)] * 6, Verdict.CANNOT_TELL, 6),
        ([(["yes"], MADE)] * 6, Verdict.NOT_RUN, 0),
        ([(["yes"], VARIED)] * 6, Verdict.NOT_RUN, 0),
    ],
)
def test_most_data_sets_for_learning_decide(datasets, verdict, n):
    found = finding(*datasets)
    assert (found.verdict, found.n) == (verdict, n)
