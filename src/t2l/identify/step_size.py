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
TICK_S = 1e-3  # numerics: of a loop that is faster


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
    noise, chosen, request = (
        noise_floor(list(recordings)),
        _some(recordings),
        _as_is(model, recordings),
    )
    last = None
    for substeps in (*SUBSTEPS, 2 * SUBSTEPS[-1]):
        q = Predictor(model.robot, chosen, substeps).predict([request])[0][0]
        # half the step halves the error, so that the longer step's is twice the change
        if last is not None and 2 * _rms(q - last) < NEGLIGIBLE * noise:
            return substeps // 2
        last = q
    return SUBSTEPS[-1]


def coarseness_for(model: Model, recordings: Sequence[Recording], substeps: int) -> int:
    """Periods a tick of a loop that is faster than `TICK_S`, if that leaves a negligible error.

    One period else.
    """
    slowest = min(recording.control_rate_hz for recording in recordings)
    periods = int(TICK_S * slowest + 1e-6)
    if periods <= 1:
        return 1
    chosen, request = _some(recordings), _as_is(model, recordings)
    real, coarse = (
        Predictor(model.robot, chosen, substeps, coarseness=ticks).predict([request])[0][0]
        for ticks in (1, periods)
    )
    return periods if _rms(coarse - real) < NEGLIGIBLE * noise_floor(list(recordings)) else 1


def _some(recordings: Sequence[Recording]) -> list[Recording]:
    """That tell nearly what all do."""
    count = min(SHORTLISTED, len(recordings))
    places = np.linspace(0, len(recordings) - 1, count).round().astype(int)
    return [busiest(recordings[place]) for place in places]


def _as_is(model: Model, recordings: Sequence[Recording]) -> Request:
    layout, u = model.vector(recordings[0].joints)
    return Request(layout, u[None])


def _rms(change: np.ndarray) -> float:
    """Of what is finite; infinite where nothing is."""
    finite = change[np.isfinite(change)]
    return float(np.sqrt(np.mean(finite**2))) if len(finite) else np.inf
