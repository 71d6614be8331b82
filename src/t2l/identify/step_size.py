"""How finely to step: the error of integration must vanish beside the noise of measurement."""

from collections.abc import Sequence

import numpy as np

from t2l.identify.levels import NEGLIGIBLE, SHORTLISTED
from t2l.identify.model import Model
from t2l.identify.noise_floor import noise_floor
from t2l.identify.prediction import Predictor, Request
from t2l.recordings.recording import Recording

SUBSTEPS = (1, 2, 4, 8)  # numerics: tried in turn: each halves the step


def substeps_for(model: Model, recordings: Sequence[Recording]) -> int:
    """The fewest physics steps a control tick that leave a negligible error of integration."""
    noise = noise_floor(list(recordings))
    count = min(SHORTLISTED, len(recordings))
    places = np.linspace(0, len(recordings) - 1, count).round().astype(int)
    chosen = [recordings[place] for place in places]
    layout, u = model.vector(recordings[0].joints)
    request = Request(layout, u[None])
    last = None
    for substeps in (*SUBSTEPS, 2 * SUBSTEPS[-1]):
        q = Predictor(model.robot, chosen, substeps).predict([request])[0][0]
        # half the step halves the error, so that the longer step's is twice the change
        if last is not None:
            change = (q - last)[np.isfinite(q - last)]
            if len(change) and 2 * np.sqrt(np.mean(change**2)) < NEGLIGIBLE * noise:
                return substeps // 2
        last = q
    return SUBSTEPS[-1]
