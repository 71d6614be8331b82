"""Of everything that a search depends on, so that an interrupted one knows its own steps."""

import hashlib
from collections.abc import Sequence
from dataclasses import fields

import numpy as np

from t2l.identify.model import Model
from t2l.identify.prediction import Predictor
from t2l.registry import python_files
from t2l.robots import plant
from t2l.version import library


def fingerprint_of(model: Model, split: str, predictors: Sequence[Predictor]) -> str:
    """Of a model, recordings and this code.

    Args:
        split: how the samples are shared out.
        predictors: of the recordings of each part; all with as many substeps as the first.
    """
    first = predictors[0]
    digest = hashlib.sha256(repr((model, split, first.substeps)).encode())
    digest.update(library().encode())
    # compiled: with what the MJCF includes, and the inertia of its meshes
    digest.update(plant.as_bytes(first.model()))
    for path in python_files(model.effect_files):
        digest.update(path.read_bytes())
    for predictor in predictors:
        for recording in predictor.recordings:
            for field in fields(recording):
                value = getattr(recording, field.name)
                array = isinstance(value, np.ndarray)
                # where a recording lies says nothing of what is in it
                if field.name not in ("path", "notes"):
                    digest.update(value.tobytes() if array else repr(value).encode())
    return digest.hexdigest()
