"""Coarser simulations to choose and fit effects by, where there are many recordings."""

from dataclasses import replace

import numpy as np

from t2l.discrepancy.evidence import MANY, Evidence
from t2l.discrepancy.prediction import Request
from t2l.effects.term import Layout

COARSENESS = (5, 2)  # control periods a tick that are tried
NEGLIGIBLE = 0.1  # of the error that the model leaves: changes its square by 1 %


def coarser(evidence: Evidence, layout: Layout, u: np.ndarray) -> Evidence:
    """`evidence` with all but `train` and `holdout` simulated at fewer ticks.

    At the fewest that change the prediction of model `layout`, `u` negligibly beside its error.
    Where there are few recordings nothing is gained, and every tick is simulated.
    """
    if len(evidence.train.recordings) < MANY:
        return evidence
    screen, request = evidence.screen, Request(layout, u[None])
    exact = screen.predict([request])[0][0]
    error = np.sqrt(np.mean((exact - screen.samples.q) ** 2))
    for coarseness in COARSENESS:
        coarse = screen.of(screen.recordings, coarseness)
        change = np.sqrt(np.mean((coarse.predict([request])[0][0] - exact) ** 2))
        if change < NEGLIGIBLE * error:
            return replace(
                evidence,
                screen=coarse,
                shortlist=evidence.shortlist.of(evidence.shortlist.recordings, coarseness),
                draft=evidence.train.of(evidence.train.recordings, coarseness),
            )
    return evidence
