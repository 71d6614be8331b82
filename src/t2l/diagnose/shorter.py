"""Every effect tried on the beginnings of long recordings, where these show the same error."""

from dataclasses import replace

import numpy as np

from t2l.diagnose.evidence import Evidence
from t2l.effects.term import Layout
from t2l.identify.prediction import Request

SCREENED_S = 5.0  # of a recording half as long again or longer
ALIKE = 0.5  # of a joint's mean squared error: what is cut off is no other


def shorter(evidence: Evidence, layout: Layout, u: np.ndarray) -> Evidence:
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
