"""What claims say of planted tables."""

from math import isnan

from t2l.stats.verdict import ALPHA, Verdict
from t2l.study.scoreboard.table import CHAINS
from tests.study.planted import evidence

CLAIMS = {claim.key: claim for claims in CHAINS.values() for claim in claims}
YES, NO = Verdict.REPRODUCED, Verdict.NOT_REPRODUCED
OPEN, NOT_RUN = Verdict.CANNOT_TELL, Verdict.NOT_RUN


def verdict(key, **tables):
    found = CLAIMS[key].finding(evidence(**tables))
    if not isnan(found.p):
        assert (found.p <= ALPHA) == (found.verdict is YES)
        assert found.n
    return found.verdict
