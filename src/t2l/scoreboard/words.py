"""Our numbers in a finding, as a person reads them."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from t2l.stats.text import rate
from t2l.stats.verdict import Finding


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
