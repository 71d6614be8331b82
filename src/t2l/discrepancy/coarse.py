"""Coarser simulations to choose and fit effects by, where there are many recordings."""

from dataclasses import replace

import numpy as np

from t2l.discrepancy.evidence import MANY, Evidence
from t2l.discrepancy.noise import noise_floor
from t2l.discrepancy.prediction import Request
from t2l.effects.term import Layout

COARSENESS = (5, 4, 2)  # control periods a tick that are tried
NEGLIGIBLE = 0.3  # of the noise: adds 4 % to an error that is noise alone


def coarser(evidence: Evidence, layout: Layout, u: np.ndarray) -> Evidence:
    """`evidence` with all but `train` and `holdout` simulated at fewer ticks.

    At the fewest that change the prediction of model `layout`, `u` negligibly beside the noise of
    what was measured. Where there are few recordings every tick is simulated.
    """
    if len(evidence.train.recordings) < MANY:
        return evidence
    screen, request = evidence.screen, Request(layout, u[None])
    exact = screen.predict([request])[0][0]
    noise = noise_floor(list(screen.recordings))
    for coarseness in COARSENESS:
        coarse = screen.of(screen.recordings, coarseness)
        change = np.sqrt(np.mean((coarse.predict([request])[0][0] - exact) ** 2))
        if change < NEGLIGIBLE * noise:
            shortlist, train, holdout = (
                predictor.of(predictor.recordings, coarseness)
                for predictor in (evidence.shortlist, evidence.train, evidence.holdout)
            )
            return replace(
                evidence, screen=coarse, shortlist=shortlist, draft=train, holdout_draft=holdout
            )
    return evidence
