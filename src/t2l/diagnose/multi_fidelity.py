"""Cheaper evidence to choose and fit effects by.

Every effect is tried on what is cheap, and what looks likeliest on what is dear: on the beginnings
of long recordings, and with coarser ticks of the control loop.
"""

from dataclasses import replace

import numpy as np

from t2l.diagnose.evidence import Evidence
from t2l.diagnose.settings import LEAST_BLOCKS
from t2l.effects.term import Layout
from t2l.identify.block_bootstrap import BLOCK_S
from t2l.identify.levels import AT_THE_FLOOR, HALF
from t2l.identify.noise_floor import noise_floor
from t2l.identify.prediction import Request

COARSENESS = (5, 4, 2)  # numerics: control periods a tick that are tried
# derived: of a recording half as long again or longer: enough blocks for a resample
SCREENED_S = LEAST_BLOCKS * 2 * BLOCK_S
# derived: of the noise: what adds more to an error that is noise alone makes it more than that
UNFELT = (AT_THE_FLOOR**2 - 1) ** 0.5
ALIKE = HALF  # of a joint's mean squared error: what is cut off is no other


def with_coarser_ticks(evidence: Evidence, layout: Layout, u: np.ndarray) -> Evidence:
    """`evidence` with what is screened and shortlisted simulated at fewer ticks.

    At the fewest that leave the prediction of model `layout`, `u` as near as counts as noise. The
    likeliest effects that feel such ticks more are fitted on every one.
    """
    screen, request = evidence.screen, Request(layout, u[None])
    exact = screen.predict([request])[0][0]
    limit = UNFELT * noise_floor(list(screen.recordings))
    for coarseness in COARSENESS:
        coarse = screen.of(screen.recordings, coarseness)
        change = np.sqrt(np.mean((coarse.predict([request])[0][0] - exact) ** 2))
        if change < limit:
            shortlist = evidence.shortlist
            shortlist = (
                coarse if shortlist is screen else shortlist.of(shortlist.recordings, coarseness)
            )
            return replace(evidence, screen=coarse, shortlist=shortlist)
    return evidence


def with_beginnings(
    evidence: Evidence, layout: Layout, u: np.ndarray, q: np.ndarray | None = None
) -> Evidence:
    """`evidence` with `SCREENED_S` of long recordings screened.

    If model `layout`, `u` misses as much there as later, in each joint; else as it is. What
    is shortlisted is cut likewise where it is what is screened.

    Args:
        q: (nsample,) what it predicts of what is screened, rad, where that is known.
    """
    screen, mask, samples = evidence.screen, evidence.screen_mask, evidence.screen.samples
    # numerics: less saves little
    if max(recording.duration_s for recording in screen.recordings) < 1.5 * SCREENED_S:
        return evidence
    q = screen.predict([Request(layout, u[None])])[0][0] if q is None else q
    square = (q - samples.q) ** 2
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
