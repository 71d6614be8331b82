"""What measurement alone costs: encoder noise and quantisation, read off the recordings."""

from functools import cache
from math import comb

import numpy as np

from t2l.recordings.recording import Recording

ORDERS = (2, 3, 4, 5)  # numerics: of differences: motion fades with the order, noise does not
# statistics: two standard errors, times sqrt(blocks), of one order's variance over another's
SPREAD = 0.8
BLOCK = 24  # numerics: samples whose differences are pooled before the median is taken


def noise_floor(
    recordings: list[Recording],
    residuals: list[np.ndarray] | None = None,
    divided: bool = False,
) -> float:
    """RMS error in rad that a perfect model would have, over all measured samples.

    Differences of order d of a smooth signal vanish while white noise of variance σ² gives them
    the variance C(2d, d) σ². Per joint the lowest order that no higher one clearly undercuts,
    and the median over short blocks, keep what is left of the signal out. A joint at rest hides
    its noise below the encoder's step, whose rounding error is then counted.

    Args:
        residuals: (n, njoint) measured minus predicted per recording, NaN where not sampled; from
            them the signal is gone already. Without them, the measured positions.
        divided: take divided differences: of a motion whose rows are late others do not vanish, and
            look like noise of up to ten times the encoder's.
    """
    total, count = 0.0, 0
    for j in range(recordings[0].q.shape[1]):
        measured = [r.q[~np.isnan(r.q[:, j]), j] for r in recordings]
        series = measured
        if residuals is not None:
            left = [r[~np.isnan(r[:, j]), j] for r in residuals]
            series = left if all(len(x) for x in left) else measured
        n = sum(len(x) for x in measured)
        taken = [r.time[~np.isnan(r.q[:, j])] for r in recordings] if divided else None
        white = _least([_white(series, taken), _white(measured, taken)], n // BLOCK)
        total += n * max(white, _step(measured) ** 2 / 12)  # statistics: variance of rounding
        count += n
    return float(np.sqrt(total / count))


def noise_of(values: np.ndarray, time: np.ndarray) -> float:
    """Likewise of one signal (n,), in its own unit, whose samples were taken then, s."""
    white = _least([_white([values], [time])], len(values) // BLOCK)
    return float(np.sqrt(max(white, _step([values]) ** 2 / 12)))  # statistics: as above


def _white(series: list[np.ndarray], taken: list[np.ndarray] | None = None) -> float:
    """Variance of the white part of some signals, whose samples were `taken` then, s."""
    estimates = []
    times = taken or [None] * len(series)
    for order in ORDERS:
        pairs = zip(series, times, strict=True)
        blocks = [_blocks(signal, order, time) for signal, time in pairs if len(signal) > order]
        if blocks:
            estimates.append(np.median(np.concatenate(blocks)) / _median_of_unit_noise(order))
    return _least(estimates, sum(len(signal) for signal in series) // BLOCK)


def _least(estimates: list[float], blocks: int) -> float:
    """The first, unless another is clearly lower: a bare minimum of estimates would be biased."""
    clearly_lower = 1 - SPREAD / np.sqrt(max(blocks, 4))
    chosen = estimates[0] if estimates else 0.0
    for estimate in estimates[1:]:
        if estimate < clearly_lower * chosen:
            chosen = estimate
    return float(chosen)


def _blocks(signal: np.ndarray, order: int, time: np.ndarray | None = None) -> np.ndarray:
    """Estimates of the variance from blocks of differences."""
    if time is None:
        squares = np.diff(signal, order) ** 2 / comb(2 * order, order)
    else:
        squares = _divided_differences(signal, time, order) ** 2
    size = min(BLOCK, len(squares))
    whole = len(squares) // size * size
    return squares[:whole].reshape(-1, size).mean(axis=1)


def _divided_differences(signal: np.ndarray, time: np.ndarray, order: int) -> np.ndarray:
    """Of unit weight: white noise keeps its variance."""
    n = len(signal) - order
    points = [slice(i, i + n) for i in range(order + 1)]
    gap = (time[order:] - time[:n]) / order
    total, square = np.zeros(n), np.zeros(n)
    for one in points:
        weight = np.ones(n)
        for other in points:
            if other != one:
                weight *= gap / (time[one] - time[other])
        total += weight * signal[one]
        square += weight**2
    return total / np.sqrt(square)


@cache
def _median_of_unit_noise(order: int) -> float:
    """What the median over blocks gives for white noise of variance one; below one, as skewed."""
    # numerics: blocks, of which the median is taken
    noise = np.random.default_rng(0).standard_normal(200 * BLOCK)
    return float(np.median(_blocks(noise, order)))


def _step(series: list[np.ndarray]) -> float:
    """The encoder's step, rad; 0 where the values lie on no grid."""
    values = np.unique(np.round(np.concatenate(series), 9))
    if len(values) < 3:
        return 0.0
    gaps = np.diff(values)
    step = gaps[gaps > 1e-8].min(initial=np.inf)
    if not np.isfinite(step):
        return 0.0
    multiples = gaps / step
    on_grid = np.abs(multiples - np.round(multiples)) < 0.1  # numerics: rounding of a log
    return float(step) if on_grid.mean() > 0.95 else 0.0  # statistics: some rows are off
