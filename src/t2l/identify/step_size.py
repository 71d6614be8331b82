"""How finely to step: the error of integration must vanish beside the noise of measurement."""

from collections.abc import Sequence

import numpy as np

from t2l.identify.model import Model
from t2l.identify.noise_floor import noise_floor
from t2l.identify.prediction import Predictor, Request
from t2l.recordings.recording import Recording

SUBSTEPS = (1, 2, 4, 8)
NEGLIGIBLE = 0.25  # of the noise: adds 3 % to an error that is noise alone
PROBED = 3  # recordings


def substeps_for(model: Model, recordings: Sequence[Recording]) -> int:
    """The fewest physics steps a control tick whose halving changes the prediction negligibly."""
    noise = noise_floor(list(recordings))
    every = max(1, len(recordings) // PROBED)
    chosen = list(recordings)[::every][:PROBED]
    layout, u = model.vector(recordings[0].joints)
    request = Request(layout, u[None])
    last = None
    for substeps in (*SUBSTEPS, 2 * SUBSTEPS[-1]):
        q = Predictor(model.robot, chosen, substeps).predict([request])[0][0]
        # half the step halves the error, so that the change is as large as what is left
        if last is not None and np.sqrt(np.nanmean((q - last) ** 2)) < NEGLIGIBLE * noise:
            return substeps // 2
        last = q
    return SUBSTEPS[-1]
