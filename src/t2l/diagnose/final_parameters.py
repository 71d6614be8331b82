"""The parameters of a final model, with intervals: what an explanation comes to in numbers."""

from typing import Any

import numpy as np

from t2l.identify.model import Model
from t2l.identify.prediction import Predictor
from t2l.identify.refit import at_its_values


def parameters_of(final: Model, predictor: Predictor, mask: np.ndarray) -> list[dict[str, Any]]:
    """A row a number of `final`: effect, title, joint, parameter, value, ci95, unit, meaning.

    The intervals are of all numbers at once, at the values that the model has, on the samples that
    they were fitted to. `joint` is None for a number of the whole robot, and `ci95` where the data
    do not tell, or where the parameter has no derivative to tell by.

    Args:
        mask: (nsample,) bool.
    """
    joints = predictor.joints
    if not any(term.effect.parameters for term in final.terms(joints)):
        return []
    found = at_its_values(final, predictor, mask)
    theta = found.layout.theta(found.u)
    told = np.isfinite(found.error) & ~found.layout.rough
    told[found.unexcited()] = False
    return [
        {
            "effect": slot.term.effect.name,
            "title": slot.term.effect.title,
            "joint": None if slot.joint is None else joints[slot.joint],
            "parameter": slot.parameter.name,
            "value": float(theta[i]),
            "ci95": list(found.interval(i)) if told[i] else None,
            "unit": slot.parameter.unit,
            "meaning": slot.parameter.meaning,
        }
        for i, slot in enumerate(found.layout.slots)
    ]
