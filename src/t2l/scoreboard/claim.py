"""A statement of the study that can be reproduced or not."""

from collections.abc import Callable
from dataclasses import dataclass

from t2l.published.numbers import Published, claims
from t2l.scoreboard.evidence import AbsentError, Evidence
from t2l.stats.verdict import ALPHA, Finding, Verdict

# from tables, the study's numbers, and how many tests p is corrected for
Judge = Callable[[Evidence, Published, int], Finding]


def nothing(evidence: Evidence, published: Published, tests: int) -> Finding:
    """The judge of what t2l has no experiment for."""
    raise AbsentError("no experiment of t2l tells")


@dataclass(frozen=True)
class Claim:
    """Attributes:
    key: names the entry of `t2l.published.numbers`.
    statement: of the study, in our words.
    unit: of replication, whose number is n.
    rule: what is tested, and what p is of.
    null: the hypothesis that a test rejects; empty where an interval decides.
    judge: applies the rule; raises `AbsentError` where its tables are not there.
    tests: that p is corrected for (Bonferroni), as in the study where it corrects.
    """

    key: str
    statement: str
    unit: str = ""
    rule: str = ""
    null: str = ""
    judge: Judge = nothing
    tests: int = 1
    alpha: float = ALPHA

    @property
    def published(self) -> Published:
        """What the study says."""
        return claims()[self.key]

    def finding(self, evidence: Evidence) -> Finding:
        """Our number and the verdict; `not run` where a table that it needs is not there."""
        try:
            return self.judge(evidence, self.published, self.tests)
        except AbsentError as absent:
            return Finding(Verdict.NOT_RUN, ours=str(absent))
