"""D-optimal choice of experiments by exchange.

The criterion is log det(I + Σ M_i) over the chosen experiments' information M_i, in units in which
every parameter is known to ±1 beforehand: Bayesian D-optimality (Chaloner and Verdinelli, Bayesian
experimental design: a review, 1995, eq. 3). It is finite where a motion tells nothing of a
parameter, and what is told twice counts little.
"""

from collections.abc import Sequence

import numpy as np

GAINED = 1e-9  # numerics: relative; less is rounding


def log_det(information: np.ndarray) -> float:
    """log det(I + M) of M (n, n)."""
    return float(np.linalg.slogdet(np.eye(len(information)) + information)[1])


def exchange(information: np.ndarray, count: int) -> list[int]:
    """Which `count` of N experiments together tell most, in order of choice.

    Each is first chosen as what adds most to those before; then any is exchanged for another while
    that gains (Fedorov, Theory of optimal experiments, 1972, chapter 3). None is chosen twice.

    Args:
        information: (N, n, n).
        count: at most N are chosen.
    """
    chosen: list[int] = []
    for _ in range(min(count, len(information))):
        chosen.append(_best(information, chosen)[0])
    improved = True
    while improved:
        improved = False
        for place in range(len(chosen)):
            others = chosen[:place] + chosen[place + 1 :]
            now = log_det(information[chosen].sum(axis=0))
            best, value = _best(information, others)
            if value > now + GAINED * abs(now):
                chosen[place], improved = best, True
    return chosen


def _best(information: np.ndarray, others: Sequence[int]) -> tuple[int, float]:
    """What adds most to `others`, and the criterion with it."""
    have = information[list(others)].sum(axis=0)
    left = [i for i in range(len(information)) if i not in others]
    values = [log_det(have + information[i]) for i in left]
    best = int(np.argmax(values))
    return left[best], values[best]
