"""A statement of the study that can be reproduced or not."""

from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, replace

from t2l.stats.collections import FEWEST
from t2l.stats.verdict import ALPHA, Finding, Verdict
from t2l.study.evidence import AbsentError, AmbiguousError, Evidence
from t2l.study.published.numbers import Published, claims

# from tables, the study's numbers, and how many tests p is corrected for
Judge = Callable[[Evidence, Published, int], Finding]


def nothing(evidence: Evidence, published: Published, tests: int) -> Finding:
    """The judge of what t2l has no experiment for."""
    raise AbsentError("no experiment of t2l tells")


@dataclass(frozen=True)
class Claim:
    """Attributes:
    key: names the entry of `t2l.study.published.numbers`.
    statement: of the study, in our words.
    unit: of replication, whose number is n.
    rule: what is tested, and what p is of.
    null: the hypothesis that a test rejects; empty where an interval decides.
    judge: applies the rule; raises `AbsentError` where its tables are not there.
    tests: that p is corrected for (Bonferroni), as in the study where it corrects.
    about: the study of ours, in config/studies, whose results it is judged by; another's only if
        that one lacks them (`Evidence.of_one`). Empty where the judge itself takes parts from
        several, or there is no experiment.
    anew: a study of ours whose results count before all others if it has enough collections.
    """

    key: str
    statement: str
    unit: str = ""
    rule: str = ""
    null: str = ""
    judge: Judge = nothing
    tests: int = 1
    alpha: float = ALPHA
    about: str = ""
    anew: str = ""

    @property
    def published(self) -> Published:
        """What the study says."""
        return claims()[self.key]

    def finding(self, evidence: Evidence) -> Finding:
        """Our number and the verdict; `not run` where a table that it needs is not there."""
        drawn = evidence.only(self.anew)
        if 1 + len(drawn.names("anew", "number")) >= FEWEST:
            with suppress(AbsentError):
                return self._judged(drawn)
        try:
            return (
                evidence.of_one(self.about, self._judged) if self.about else self._judged(evidence)
            )
        except AbsentError as absent:
            return Finding(Verdict.NOT_RUN, ours=str(absent))
        except AmbiguousError as several:
            # no error: one row that needs a choice must not cost all others their table
            return Finding(Verdict.CANNOT_TELL, ours=str(several))

    def _judged(self, evidence: Evidence) -> Finding:
        found = self.judge(evidence, self.published, self.tests)
        return replace(found, results=", ".join(evidence.studies) if self.about else "")
