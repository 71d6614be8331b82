"""How finely to step: the error of integration must vanish beside the noise of measurement."""

from collections.abc import Sequence

import numpy as np

from t2l.identify.levels import NEGLIGIBLE, SHORTLISTED
from t2l.identify.model import Model
from t2l.identify.noise_floor import noise_floor
from t2l.identify.prediction import Predictor, Request
from t2l.recordings.checks import LEAST_SAMPLES
from t2l.recordings.recording import Recording

LONGEST_S = 60.0  # numerics: of a recording; errors of integration do not add up under feedback
SUBSTEPS = (1, 2, 4, 8)  # numerics: tried in turn: each halves the step


def busiest(recording: Recording, duration_s: float = LONGEST_S) -> Recording:
    """A part of a recording, of `duration_s` at most, in which the commands move most."""
    if recording.duration_s <= duration_s:
        return recording
    elapsed = recording.time - recording.time[0]
    travel = np.abs(np.diff(recording.q_des, axis=0, prepend=recording.q_des[:1])).sum(axis=1)
    starts = np.arange(0.0, elapsed[-1] - duration_s, duration_s / 2)
    went = np.interp([starts, starts + duration_s], elapsed, np.cumsum(travel))
    measured = ~np.isnan(recording.q)
    for start in starts[np.argsort(went[0] - went[1], kind="stable")]:
        rows = (elapsed >= start) & (elapsed < start + duration_s)
        if (measured[rows].sum(axis=0) >= LEAST_SAMPLES).all():
            return recording.part(start, start + duration_s)
    return recording


def substeps_for(model: Model, recordings: Sequence[Recording]) -> int:
    """The fewest physics steps a control tick that leave a negligible error of integration.

    Of long recordings only the part is looked at in which the commands move most.
    """
    count = min(SHORTLISTED, len(recordings))
    places = np.linspace(0, len(recordings) - 1, count).round().astype(int)
    chosen = [busiest(recordings[place]) for place in places]
    layout, u = model.vector(recordings[0].joints)
    request = Request(layout, u[None])
    last = noise = None
    for substeps in (*SUBSTEPS, 2 * SUBSTEPS[-1]):
        predictor = Predictor(model.robot, chosen, substeps)
        q = predictor.predict([request])[0][0]
        if noise is None:
            # of what the model leaves: late rows make the noise of a motion seem larger
            left = predictor.samples.by_row(predictor.samples.q - q)
            noise = noise_floor(chosen, left, divided=True)
        # half the step halves the error, so that the longer step's is twice the change
        if last is not None:
            change = (q - last)[np.isfinite(q - last)]
            if len(change) and 2 * np.sqrt(np.mean(change**2)) < NEGLIGIBLE * noise:
                return substeps // 2
        last = q
    return SUBSTEPS[-1]
