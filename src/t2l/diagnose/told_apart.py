"""Of an explanation's names, which cannot be told from other effects."""

from dataclasses import replace

import numpy as np

from t2l.diagnose.confounded import sentences
from t2l.diagnose.confounding import confounded_names
from t2l.diagnose.explanation import Explanation
from t2l.identify.model import Model
from t2l.identify.prediction import Predictor


def told_apart(
    explanation: Explanation, came: Model, predictor: Predictor, mask: np.ndarray
) -> Explanation:
    """The explanation, and in its sentence which names cannot be told from other effects.

    Args:
        came: the model as it came.
        mask: (nsample,) bool, samples that fit and choose.
    """
    found = confounded_names(explanation.model, came, predictor, mask)
    if not found:
        return explanation
    said = sentences(found, came.known_effects(), predictor.recordings)
    sentence = " ".join([explanation.sentence, *said])
    return replace(explanation, confounded=tuple(found), sentence=sentence)
