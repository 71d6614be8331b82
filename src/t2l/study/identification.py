"""Claims about system identification: how S* depends on the gains."""

import numpy as np
import pandas as pd

from t2l.stats.bootstrap import ratio
from t2l.stats.verdict import Finding, greater, within
from t2l.study.claim import Claim
from t2l.study.evidence import Evidence
from t2l.study.published.numbers import Published, splits
from t2l.study.words import among

# with all parameters free, as the paper identifies
STUDY = "identification_published"
RULE = "S* of cells, one-sided Mann-Whitney"


def errors(evidence: Evidence) -> pd.DataFrame:
    """A row a cell: kp, kd, region, error: S* over positions and velocities."""
    table = evidence.table("identification", ("kp", "kd", "s_star"))
    return table.assign(error=table.s_star, region=splits()["transfer"].regions(table.kp, table.kd))


def _parts(evidence: Evidence, region: str) -> tuple[np.ndarray, np.ndarray]:
    cells = errors(evidence)
    inside = (cells.region == region).to_numpy()
    return cells.error.to_numpy()[inside], cells.error.to_numpy()[~inside]


def _so_lowest(evidence: Evidence, published: Published, tests: int) -> Finding:
    so, rest = _parts(evidence, "SO")
    return among(greater(rest, so, tests=tests), "{:.2g} and {:.2g}", so, rest)


def _factor(evidence: Evidence, published: Published, tests: int) -> Finding:
    so, rest = _parts(evidence, "SO")
    found = within(ratio, rest, so, low=published.values["factor"])
    return among(found, "{:.1f} times lower", [float(ratio(rest, so)) if len(so) else np.nan])


def _co_highest(evidence: Evidence, published: Published, tests: int) -> Finding:
    co, rest = _parts(evidence, "CO")
    return among(greater(co, rest, tests=tests), "{:.2g} and {:.2g}", co, rest)


CLAIMS = [
    Claim(
        "identification_so_lowest",
        "Identification leaves the smallest error at stiff, overdamped gains.",
        "cell",
        f"{RULE}: SO below all others",
        "S* in SO is not smaller",
        _so_lowest,
        about=STUDY,
    ),
    Claim(
        "identification_factor",
        "That error is more than ten times smaller than elsewhere.",
        "cell",
        "ratio of geometric means outside and in SO, by its bootstrap interval",
        judge=_factor,
        about=STUDY,
    ),
    Claim(
        "identification_co_highest",
        "The largest error is at compliant, overdamped gains.",
        "cell",
        f"{RULE}: CO above all others",
        "S* in CO is not greater",
        _co_highest,
        about=STUDY,
    ),
]
