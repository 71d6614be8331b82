"""How each joint of some motions answers its commands: all measures of it together."""

from dataclasses import dataclass

import numpy as np

from t2l.response.frequency_response import FrequencyResponse, frequency_response
from t2l.response.lag import Lag, lag
from t2l.response.motions import Motions
from t2l.response.overshoot import Overshoot, overshoot
from t2l.response.region import STIFF_FROM_HZ, Region, region
from t2l.response.second_order import SecondOrder, fit
from t2l.response.track import Track

FEWEST_SAMPLES = 2  # measured, of a motion that tells anything
MOST_ROWS = 60_000  # that a fit looks at: more narrow no interval that matters
STILL = 1e-6  # of the commands' own size: a joint whose commands change less is not asked


@dataclass(frozen=True)
class JointResponse:
    """One joint; `lag`, `frequencies` and `overshoot` are None where the motion shows none.

    Attributes:
        label: of its motions.
        unit: of commands and positions.
        logged: Kp N·m/rad and Kd N·m·s/rad by the log, if it states them.
        amplitude: half the range of the commands, and of the positions.
    """

    label: str
    joint: str
    unit: str
    logged: tuple[float, float] | None
    amplitude: tuple[float, float]
    lag: Lag | None
    frequencies: FrequencyResponse | None
    overshoot: Overshoot | None
    fit: SecondOrder
    region: Region
    rows: tuple[tuple[np.ndarray, np.ndarray, np.ndarray], ...]


def responses(
    motions: Motions, stiff_from_hz: float = STIFF_FROM_HZ, seed: int = 0
) -> list[JointResponse]:
    """Of every joint that is commanded to move."""
    found = []
    for j, joint in enumerate(motions.joints):
        rows = _kept(
            [
                (time, c[:, j], q[:, j])
                for time, c, q in motions.rows
                if np.isfinite(q[:, j]).sum() >= FEWEST_SAMPLES
            ]
        )
        if not rows:
            continue
        command = np.concatenate([c for _, c, _ in rows])
        if np.ptp(command) <= STILL * max(1.0, np.abs(command).max()):
            continue
        logged = None
        if motions.logged is not None:
            logged = tuple(float(gains[j]) for gains in motions.logged)
        found.append(_response(motions, joint, logged, rows, stiff_from_hz, seed))
    return found


def _kept(rows: list) -> tuple:
    """The first motions, of `MOST_ROWS` rows together; at least one."""
    ends = np.cumsum([len(time) for time, _, _ in rows])
    return tuple(rows[: max(1, int(np.searchsorted(ends, MOST_ROWS, side="right")))])


def _response(motions: Motions, joint, logged, rows, stiff_from_hz, seed) -> JointResponse:
    rng = np.random.default_rng(seed)
    tracks = [Track.of(time, command, q) for time, command, q in rows]
    found = fit(tracks)
    period = float(np.median(np.concatenate([np.diff(time) for time, _, _ in rows])))
    pairs = [_on_grid(time, command, q, period) for time, command, q in rows]
    q = np.concatenate([positions[np.isfinite(positions)] for _, _, positions in rows])
    command = np.concatenate([c for _, c, _ in rows])
    return JointResponse(
        label=motions.label,
        joint=joint,
        unit=motions.unit,
        logged=logged,
        amplitude=(float(np.ptp(command)) / 2, float(np.ptp(q)) / 2),
        lag=lag(pairs, period, rng),
        frequencies=frequency_response(pairs, period),
        overshoot=overshoot(rows, found.rmse, rng),
        fit=found,
        region=region(found.omega, found.zeta, found.covariance, stiff_from_hz),
        rows=tuple(rows),
    )


def _on_grid(time, command, q, period) -> tuple[np.ndarray, np.ndarray]:
    """Command (held) and position (linear between measurements) at every period."""
    measured = np.isfinite(q)
    at = np.arange(time[0], time[measured][-1] + 1e-9, period)
    held = np.searchsorted(time, at + 1e-3 * period, side="right") - 1
    return command[held], np.interp(at, time[measured], q[measured])
