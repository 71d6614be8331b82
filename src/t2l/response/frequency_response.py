"""Gain and phase of a joint over frequency: the empirical transfer function of its commands.

H = S_cq / S_cc by Welch's method, with its coherence γ² and the random errors that follow from it
(Bendat and Piersol, Random Data, 4th edition, section 9.2.4, equations 9.90 and 9.91).
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.signal import csd, welch

SEGMENTS = 3  # fewest that are averaged over: one alone is always coherent
LONGEST_SEGMENT_S = 8.0  # resolves 0.13 Hz
FLANK = 0.3  # of a neighbour's power: Hann's window gives the neighbours of a tone a quarter of its
LEAST_POWER = 1e-3  # of the largest in the commands: below, there is no command to answer


@dataclass(frozen=True)
class FrequencyResponse:
    """Of the frequencies that the commands hold, (n,) each.

    Attributes:
        gain, phase_rad: of H; the phase is negative where the motion is late.
        gain_error, phase_error_rad: standard errors.
        coherence: γ².
        power: of the commands, relative to the largest.
    """

    hz: np.ndarray
    gain: np.ndarray
    phase_rad: np.ndarray
    gain_error: np.ndarray
    phase_error_rad: np.ndarray
    coherence: np.ndarray
    power: np.ndarray


def frequency_response(
    pairs: Sequence[tuple[np.ndarray, np.ndarray]], period_s: float
) -> FrequencyResponse | None:
    """Of commands and motions (n,) on one even grid; None where the commands stand still."""
    total = sum(len(command) for command, _ in pairs)
    longest = min(LONGEST_SEGMENT_S / period_s, max(len(command) for command, _ in pairs))
    size = int(min(longest, max(2 * total / (SEGMENTS + 1), 16)))
    options = {"fs": 1 / period_s, "nperseg": size, "detrend": "constant"}
    power, motion, cross, count = 0.0, 0.0, 0.0, 0
    for command, q in pairs:
        if len(command) < size:
            continue
        segments = max(1, 2 * len(command) // size - 1)
        hz, scc = welch(command, **options)
        power = power + segments * scc
        motion = motion + segments * welch(q, **options)[1]
        cross = cross + segments * csd(command, q, **options)[1]
        count += segments
    if count == 0 or not np.max(power) > 0:
        return None
    beside = np.maximum(np.r_[0.0, power[:-1]], np.r_[power[1:], 0.0])
    held = (power > LEAST_POWER * np.max(power)) & (power > FLANK * beside) & (hz > 0)
    if not held.any():
        return None
    power, motion, cross = power[held], motion[held], cross[held]
    h = cross / power
    coherence = np.clip(np.abs(cross) ** 2 / (power * np.maximum(motion, 1e-300)), 0.0, 1.0)
    random = np.sqrt((1 - coherence) / (2 * count * np.maximum(coherence, 1e-12)))
    return FrequencyResponse(
        hz[held], np.abs(h), np.unwrap(np.angle(h)), np.abs(h) * random, random, coherence,
        power / power.max(),
    )  # fmt: skip
