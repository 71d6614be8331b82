"""What motions will tell of effects, or what a log cannot: expected errors, and what is alike."""

from collections.abc import Sequence

import numpy as np

from t2l.design.expected import HIDDEN, Confounded, Expected, Identifiability
from t2l.design.sensitivity import Column, Responses, Sensitivity
from t2l.effects.effect import Effect
from t2l.identify.model import Model
from t2l.identify.noise_floor import noise_floor
from t2l.identify.uncertainty import INSEPARABLE, RIDGE
from t2l.recordings.recording import Recording

REFERENCE = 3  # recordings by which plausible sizes are chosen
MOST_RECORDINGS = 12  # of a log that are looked at, spread over it


def of_log(
    model: Model, recordings: Sequence[Recording], effects: Sequence[Effect] | None = None
) -> Identifiability:
    """What a log can tell, judged by its commands, gains and noise alone.

    Args:
        effects: by default all that the model does not have on every joint.
    """
    joints = recordings[0].joints
    if effects is None:
        effects = missing_effects(model, joints)
    looked = _spread(recordings, MOST_RECORDINGS)
    noise = max(noise_floor(list(looked)), np.finfo(float).tiny)
    sensitivity = Sensitivity(model, effects, _spread(looked, REFERENCE), noise)
    return identifiability(sensitivity, looked, len(recordings))


def missing_effects(model: Model, joints: tuple[str, ...]) -> list[Effect]:
    """Every known effect that some joint of the model does not have yet."""
    layout, _ = model.vector(joints)
    everywhere = {t.effect.name for t in layout.terms if len(t.joints) == len(joints)}
    known = model.known_effects(joints)
    return [effect for name, effect in known.items() if name not in everywhere]


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
    presences, found = sensitivity.presences, []
    for i, one in enumerate(presences):
        for j in range(i):
            names = one.effect.name, presences[j].effect.name
            if names[0] in presences[j].effect.contains or names[1] in one.effect.contains:
                continue
            both = [
                _nearest(sensitivity, grams, count, first, second)
                for first, second in ((i, j), (j, i))
            ]
            worst = min(both, key=lambda pair: (pair.difference, -pair.correlation))
            if worst.correlation > INSEPARABLE:
                found.append(worst)
    return sorted(found, key=lambda pair: pair.difference)


def _nearest(
    sensitivity: Sensitivity, grams: np.ndarray, count: np.ndarray, first: int, second: int
) -> Confounded:
    """How well an effect imitates another at its plausible size, on the joint where it does best.

    A joint on which the other does not show does not count.
    """
    ncolumn = len(sensitivity.columns)
    one, other = (sensitivity.presences[i].effect for i in (first, second))
    own = [i for i, c in enumerate(sensitivity.columns) if c.effect.name == other.name]
    whole = ncolumn + first
    best = Confounded(one.title, other.title, "", 0.0, np.inf)
    for joint, gram in enumerate(grams):
        square, samples = gram[whole, whole], max(count[joint], 1.0)
        if square < HIDDEN**2 * samples:
            continue
        correlation = _correlation(gram[np.ix_(own, own)], gram[own, whole], square)
        difference = float(np.sqrt((1 - correlation**2) * square / samples))
        if correlation > best.correlation:
            name = sensitivity.joints[joint]
            best = Confounded(one.title, other.title, name, correlation, difference)
    return best


def _correlation(columns: np.ndarray, shared: np.ndarray, square: float) -> float:
    """Of a response with the nearest combination of some columns, from their inner products."""
    norm = np.sqrt(np.maximum(np.diag(columns), np.finfo(float).tiny))
    scaled = columns / np.outer(norm, norm) + RIDGE * np.eye(len(norm))
    explained = (shared / norm) @ np.linalg.pinv(scaled, hermitian=True) @ (shared / norm)
    return float(np.sqrt(np.clip(explained / square, 0.0, 1.0)))


def _spread(recordings: Sequence[Recording], count: int) -> list[Recording]:
    if len(recordings) <= count:
        return list(recordings)
    at = np.linspace(0, len(recordings) - 1, count).round().astype(int)
    return [recordings[i] for i in at]
