"""Our numbers in a finding, as a person reads them."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from t2l.stats.text import rate
from t2l.stats.verdict import Finding, Verdict


def percents(finding: Finding, inside: Sequence[float], outside: Sequence[float]) -> Finding:
    """With the mean shares of two groups of units, and how many there are of each."""
    parts = [
        f"{rate(np.mean(group) if len(group) else np.nan)} ({len(group)})"
        for group in (inside, outside)
    ]
    return replace(finding, ours=" and ".join(parts))


def among(finding: Finding, form: str, *groups: Sequence[float]) -> Finding:
    """With the mean of each group of units, in a format."""
    means = [float(np.mean(group)) if len(group) else np.nan for group in groups]
    return replace(finding, ours=form.format(*means))


def shown(value: float, lower: float, upper: float) -> str:
    """A number with its interval, if it has one."""
    if np.isnan(lower):
        return f"{value:+.2f}"
    return f"{value:+.2f} ({lower:+.2f} to {upper:+.2f})"


def cannot_tell(finding: Finding, why: str) -> Finding:
    """Our numbers without a verdict, and why there is none."""
    ours = finding.ours or shown(finding.value, finding.lower, finding.upper)
    return replace(finding, verdict=Verdict.CANNOT_TELL, p=np.nan, ours=f"{ours}; {why}")
