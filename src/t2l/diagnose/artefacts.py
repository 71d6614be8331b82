"""A diagnosis with its reasons, written where people and `t2l adopt` find it."""

import json
import os
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from t2l.artefacts import read_json, reading, write_text
from t2l.diagnose import conditions, confounded, wording
from t2l.diagnose.confounded import Confounded
from t2l.diagnose.explained_variance import explained_variance
from t2l.diagnose.files import DIAGNOSIS
from t2l.diagnose.findings import findings
from t2l.diagnose.inverse_dynamics_residual import missing_torque
from t2l.diagnose.model_discrimination import separating_experiment
from t2l.diagnose.ranking import NOTHING_MISSING, Diagnosis, adopt
from t2l.errors import ArtefactError, writing
from t2l.identify.model import write_model
from t2l.identify.prediction import Predictor, Request
from t2l.names import is_plain, path_of


def diagnosed_effects(folder: Path) -> list[str]:
    """Names of the effects that a diagnosis in a folder ranks; none where there is none.

    Raises:
        ArtefactError: its file is no diagnosis.
    """
    path = folder / DIAGNOSIS
    if not os.path.lexists(path):
        return []
    content = read_json(path, "a diagnosis", ("ranking",))
    with reading(path, "a diagnosis with a list of effects as its ranking"):
        return [str(entry["effect"]) for entry in content["ranking"]]


def write_diagnosis(
    diagnosis: Diagnosis,
    fitted: Predictor,
    test: Predictor,
    folder: Path,
    beforehand: Sequence[Confounded] = (),
) -> dict[str, Any]:
    """Write ``diagnosis.json`` and, for each effect, the model with it in ``models/``.

    Models that the ``diagnosis.json`` before names, and this one does not, are removed.

    Args:
        fitted, test: predictors of the recordings that fit and choose, and of those that report.
        beforehand: effects that the recordings do not tell apart.

    Returns:
        The content of ``diagnosis.json``.
    """
    remaining = _give_reasons(diagnosis, fitted)
    path, models = folder / DIAGNOSIS, folder / "models"
    before = _diagnosed_before(folder)
    with writing(path):
        path.unlink(missing_ok=True)
    for candidate in diagnosis.ranking:
        name = candidate.effect.name
        write_model(
            adopt(diagnosis, name),
            path_of(models, name, ".yaml"),
            f"the model so far with {candidate.effect.title}, fitted together",
        )
    for name in before - {candidate.effect.name for candidate in diagnosis.ranking}:
        with writing(stale := path_of(models, name, ".yaml")):
            stale.unlink(missing_ok=True)
    extra = {
        "training_recordings": [r.name for r in fitted.recordings],
        "test_recordings": [r.name for r in test.recordings],
        "remaining": remaining,
        "separating_experiment": _experiment(diagnosis, fitted),
        "confounded": confounded.as_json(beforehand),
    }
    content = wording.as_json(diagnosis, extra)
    # last: its presence says that the folder is whole
    write_text(json.dumps(content, indent=2) + "\n", path)
    return content


def _diagnosed_before(folder: Path) -> set[str]:
    try:
        return set(filter(is_plain, diagnosed_effects(folder)))
    except ArtefactError:
        return set()


def _give_reasons(diagnosis: Diagnosis, predictor: Predictor) -> list[str]:
    """Say why of each candidate; return what the model's error follows, in sentences."""
    layout, u = diagnosis.model.vector(diagnosis.joints)
    joints = diagnosis.joints
    (q,), (dq,) = predictor.predict([Request(layout, u[None])], velocity=True)
    residual = predictor.samples.q - q[0]
    under = conditions.features(predictor, q[0], dq[0])
    # a torque that is missing, unlike the error it makes, is alike at all gains
    missing = missing_torque(predictor, residual)
    for candidate in diagnosis.ranking:
        found = {}
        if candidate.effect.follows in under:
            feature = under[candidate.effect.follows]
            values = conditions.correlation(missing, feature, predictor.samples.joint)
            found = {joints[j]: float(values[j]) for j in candidate.term.joints}
        candidate.why = wording.why(candidate, found, wording.titles_of(diagnosis))
    if diagnosis.verdict == NOTHING_MISSING:
        return []
    where = findings(predictor, residual, under, top=4)  # format: on the page
    where.sort(key=lambda finding: -finding.share)
    follows = explained_variance(predictor, residual, under, missing)[:3]
    return [entry.sentence for entry in (*where, *follows)]


def _experiment(diagnosis: Diagnosis, predictor: Predictor) -> dict[str, Any] | None:
    if not diagnosis.ranking or not diagnosis.ranking[0].tied_with:
        return None
    # what it proposes are positions to command
    if predictor.holding is not None:
        return None
    first = diagnosis.ranking[0]
    second = next(c for c in diagnosis.ranking if c.effect.name == first.tied_with[0])
    found = separating_experiment(
        predictor,
        (first.layout, first.u),
        (second.layout, second.u),
        diagnosis.noise_floor_rad,
    )
    return {
        "between": [first.effect.name, second.effect.name],
        "sentence": found.sentence,
        "motion": found.motion,
        "kp": found.kp.tolist(),
        "kd": found.kd.tolist(),
        "difference_rad": found.difference_rad,
    }
