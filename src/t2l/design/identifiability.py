"""What motions will tell of effects, or what a log cannot: expected errors, and what is alike."""

from collections.abc import Sequence

import numpy as np

from t2l.design.expected import HIDDEN, Confounded, Expected, Identifiability
from t2l.design.sensitivity import Column, Responses, Sensitivity
from t2l.effects.effect import Effect
from t2l.identify.levels import SHORTLISTED
from t2l.identify.model import Model
from t2l.identify.noise_floor import noise_floor
from t2l.identify.uncertainty import INSEPARABLE, RIDGE
from t2l.recordings.recording import Recording
from t2l.recordings.splits import LEAST_TO_HOLD_OUT_WHOLE

FINEST_RAD = 1e-9  # numerics: no encoder is finer, and a joint at rest has no noise
REFERENCE = LEAST_TO_HOLD_OUT_WHOLE  # recordings by which plausible sizes are chosen
MOST_RECORDINGS = SHORTLISTED  # of a log that are looked at, spread over it


def of_log(
    model: Model, recordings: Sequence[Recording], effects: Sequence[Effect] | None = None
) -> Identifiability:
    """What a log can tell, judged by its commands, gains and noise alone.

    Args:
        effects: by default all that the model does not have on every joint.
    """
    joints = recordings[0].joints
    if effects is None:
        effects = model.missing_effects(joints, recordings)
    looked = _spread(recordings, MOST_RECORDINGS)
    noise = max(noise_floor(list(looked)), FINEST_RAD)
    sensitivity = Sensitivity(model, effects, _spread(looked, REFERENCE), noise)
    return identifiability(sensitivity, looked, len(recordings))


def identifiability(
    sensitivity: Sensitivity, recordings: Sequence[Recording], of: int | None = None
) -> Identifiability:
    """What recordings tell of the effects of a sensitivity.

    Args:
        of: how many there are, if these are some of them.
    """
    ncolumn, neffect = len(sensitivity.columns), len(sensitivity.presences)
    njoint, width = len(sensitivity.joints), ncolumn + neffect
    # of columns and wholes, by joint, so that no joint's motion hides what another's cannot tell
    grams, count = np.zeros((njoint, width, width)), np.zeros(njoint)
    for part in sensitivity.responses(recordings):
        for joint in range(njoint):
            grams[joint] += _gram(part, joint)
            count[joint] += np.sum(part.joint == joint)
    together = grams.sum(axis=0)[:ncolumn, :ncolumn]
    errors = _errors(together)
    alone = np.full(ncolumn, np.inf)
    names = [column.effect.name for column in sensitivity.columns]
    for presence in sensitivity.presences:
        own = [i for i, name in enumerate(names) if name == presence.effect.name]
        alone[own] = _errors(together[np.ix_(own, own)])
    expected = [
        _expected(column, sensitivity.joints, one, all_of_them)
        for column, one, all_of_them in zip(sensitivity.columns, alone, errors, strict=True)
    ]
    alike = _confounded(sensitivity, grams, count)
    return Identifiability(
        expected, alike, sensitivity.noise_rad, len(recordings), of or len(recordings)
    )


def _gram(part: Responses, joint: int) -> np.ndarray:
    rows = part.joint == joint
    both = np.concatenate([part.columns[rows], part.wholes[rows]], axis=1)
    return both.T @ both


def _errors(information: np.ndarray) -> np.ndarray:
    """Standard errors (n,) in the units of M (n, n): the Cramér-Rao bound."""
    norm = np.sqrt(np.diag(information))
    error = np.full(len(norm), np.inf)
    known = np.flatnonzero(norm > 1e-9)
    scaled = information[np.ix_(known, known)] / np.outer(norm[known], norm[known])
    inverse = np.linalg.pinv(scaled + RIDGE * np.eye(len(known)), hermitian=True)
    error[known] = np.sqrt(np.maximum(np.diag(inverse), 0.0)) / norm[known]
    return error


def _expected(column: Column, joints: Sequence[str], alone: float, together: float) -> Expected:
    parameter = column.slot.parameter if column.slot else None
    # a change of a logarithm is a part of the value
    unit_change = column.value if parameter and parameter.log else 1.0
    return Expected(
        effect=column.effect.name,
        title=column.effect.title,
        parameter=parameter.name if parameter else "",
        joint=None if column.joint is None else joints[column.joint],
        unit=parameter.unit if parameter else "of its plausible size",
        value=column.value,
        plausible_change=column.size * unit_change,
        error=float(alone) * column.size * unit_change,
        error_together=float(together) * column.size * unit_change,
    )


def _confounded(sensitivity: Sensitivity, grams: np.ndarray, count: np.ndarray) -> list[Confounded]:
    """Pairs of effects neither of which contains the other, each once, the most alike first."""
    effects = [presence.effect for presence in sensitivity.presences]
    names = [column.effect.name for column in sensitivity.columns]
    ncolumn, found = len(names), []
    size = grams[:, range(ncolumn, grams.shape[1]), range(ncolumn, grams.shape[1])]
    rms = np.sqrt(size / np.maximum(count, 1.0)[:, None])
    alike = np.zeros((len(effects), *size.shape))
    for j, other in enumerate(effects):
        own = [i for i, name in enumerate(names) if name == other.name]
        for joint, gram in enumerate(grams):
            explained = _explained(gram[np.ix_(own, own)], gram[own, ncolumn:])
            alike[j, joint] = explained / np.maximum(size[joint], np.finfo(float).tiny)
    # on a joint where the noise hides it, an effect looks like any other
    alike = np.where(rms > HIDDEN, np.sqrt(np.clip(alike, 0.0, 1.0)), 0.0)
    for i, one in enumerate(effects):
        for j, other in enumerate(effects[:i]):
            if one.name in other.contains or other.name in one.contains:
                continue
            # either may imitate the other, on any joint
            both = ((alike[k][:, m], rms[:, m], m, k) for k, m in ((i, j), (j, i)))
            worst = max(both, key=lambda found: found[0].max())
            joint = int(np.argmax(worst[0]))
            correlation = float(worst[0][joint])
            if correlation > INSEPARABLE:
                difference = float(worst[1][joint] * np.sqrt(1 - correlation**2))
                titles = effects[worst[2]].title, effects[worst[3]].title
                found.append(
                    Confounded(*titles, sensitivity.joints[joint], correlation, difference)
                )
    return sorted(found, key=lambda pair: pair.difference)


def _explained(columns: np.ndarray, shared: np.ndarray) -> np.ndarray:
    """Squares (m,) of the parts of m responses that a combination of some columns can be.

    Args:
        columns: (k, k) inner products of the columns; `shared` (k, m) with the responses.
    """
    norm = np.sqrt(np.maximum(np.diag(columns), np.finfo(float).tiny))
    scaled = columns / np.outer(norm, norm) + RIDGE * np.eye(len(norm))
    inverse = np.linalg.pinv(scaled, hermitian=True)
    return np.einsum("km,kl,lm->m", shared / norm[:, None], inverse, shared / norm[:, None])


def _spread(recordings: Sequence[Recording], count: int) -> list[Recording]:
    if len(recordings) <= count:
        return list(recordings)
    at = np.linspace(0, len(recordings) - 1, count).round().astype(int)
    return [recordings[i] for i in at]
