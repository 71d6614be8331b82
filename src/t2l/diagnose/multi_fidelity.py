"""Cheaper evidence to choose and fit effects by, where recordings are many or long.

Every effect is tried on what is cheap, and what looks likeliest on what is dear: on the beginnings
of long recordings, and with coarser ticks of the control loop.
"""

from dataclasses import replace

import numpy as np

from t2l.diagnose.evidence import Evidence
from t2l.diagnose.settings import (
    ALIKE,
    COARSEST,
    LONG,
    MANY,
    NEGLIGIBLE,
    SCREENED_S,
    SMALL,
)  # fmt: skip
from t2l.effects.term import Layout
from t2l.identify.noise_floor import noise_floor
from t2l.identify.prediction import Request


def with_coarser_ticks(evidence: Evidence, layout: Layout, u: np.ndarray) -> Evidence:
    """`evidence` with all but `train` and `holdout` simulated at fewer ticks.

    At the fewest that change the prediction of model `layout`, `u` negligibly beside the noise of
    what was measured or beside what the model misses. Where there are few recordings and none is
    long every tick is simulated.
    """
    recordings = evidence.train.recordings
    ticks = max(recording.duration_s * recording.control_rate_hz for recording in recordings)
    if len(recordings) < MANY and ticks < LONG:
        return evidence
    screen, request = evidence.screen, Request(layout, u[None])
    exact = screen.predict([request])[0][0]
    missed = np.sqrt(np.mean((exact - screen.samples.q)[evidence.screen_mask] ** 2))
    limit = max(NEGLIGIBLE * noise_floor(list(screen.recordings)), SMALL * missed)
    for coarseness in range(COARSEST, 1, -1):
        coarse = screen.of(screen.recordings, coarseness)
        change = np.sqrt(np.mean((coarse.predict([request])[0][0] - exact) ** 2))
        if change < limit:
            shortlist, train, holdout = (
                coarse if predictor is screen else predictor.of(predictor.recordings, coarseness)
                for predictor in (evidence.shortlist, evidence.train, evidence.validation)
            )
            return replace(
                evidence, screen=coarse, shortlist=shortlist, draft=train, validation_draft=holdout
            )
    return evidence


def with_beginnings(evidence: Evidence, layout: Layout, u: np.ndarray) -> Evidence:
    """`evidence` with `SCREENED_S` of long recordings screened.

    If model `layout`, `u` misses as much there as later, in each joint; else as it is. What
    is shortlisted is cut likewise where it is what is screened.
    """
    screen, mask, samples = evidence.screen, evidence.screen_mask, evidence.screen.samples
    if max(recording.duration_s for recording in screen.recordings) < 1.5 * SCREENED_S:
        return evidence
    square = (screen.predict([Request(layout, u[None])])[0][0] - samples.q) ** 2
    early = samples.time < SCREENED_S
    for joint in range(len(screen.joints)):
        of_joint = mask & (samples.joint == joint)
        if not of_joint.any():
            continue
        first = square[of_joint & early]
        if not len(first) or first.mean() < ALIKE * square[of_joint].mean():
            return evidence
    short = screen.of([recording.beginning(SCREENED_S) for recording in screen.recordings])
    if evidence.shortlist is screen:
        evidence = replace(evidence, shortlist=short, shortlist_mask=mask[early])
    return replace(evidence, screen=short, screen_mask=mask[early])
