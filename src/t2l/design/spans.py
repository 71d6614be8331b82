"""What each effect can do to the measured positions, to second order."""

from collections.abc import Sequence

import numpy as np

from t2l.design.sensitivity import Presence, Sensitivity
from t2l.recordings.recording import Recording


def spans(
    sensitivity: Sensitivity, recordings: Sequence[Recording]
) -> tuple[np.ndarray, list[str]]:
    """Responses (nsample, k) that span what effects can do, and the name of the effect of each.

    Beside the derivatives by its parameters that is an effect's response as a whole: tangent and
    secant together hold a bend too.
    """
    parts = list(sensitivity.responses(recordings))
    columns = [np.concatenate([part.columns for part in parts])]
    wholes = np.concatenate([part.wholes for part in parts])
    joint = np.concatenate([part.joint for part in parts])
    names = [column.effect.name for column in sensitivity.columns]
    for presence, whole in zip(sensitivity.presences, wholes.T, strict=True):
        # without derivatives the whole is a column already
        if len(presence.free):
            columns.append(_by_joint(presence, whole, joint))
            names += [presence.effect.name] * columns[-1].shape[1]
    return np.concatenate(columns, axis=1), names


def _by_joint(presence: Presence, whole: np.ndarray, joint: np.ndarray) -> np.ndarray:
    """(nsample, n) a response as a whole, for each joint that has the effect by itself."""
    slots = [presence.layout.slots[i] for i in presence.own]
    if presence.effect.coupled or any(slot.joint is None for slot in slots):
        return whole[:, None]
    return np.where(joint[:, None] == np.unique(joint), whole[:, None], 0.0)
