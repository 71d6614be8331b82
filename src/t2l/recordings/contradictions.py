"""Recordings that cannot both be true: the same commands and gains, different responses."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from t2l.recordings.recording import Recording

SAME_COMMAND_RAD = 1e-6  # numerics: less is rounding
NOISE_FACTOR = 4.0 * np.sqrt(2.0)  # statistics: of a difference of two noisy samples
SAMPLES_IN_A_ROW = 3  # statistics: beyond that, so that chance explains none
# bound: shorter than this part of a command's hold is jitter of the clock
JITTER = 0.25


@dataclass(frozen=True)
class Contradiction:
    """Two recordings of one experiment that disagree.

    Attributes:
        first, second: names of the recordings.
        joint: where they disagree most.
        rms_rad: of the difference in that joint's measured positions over the common time.
        from_s: since when, from the start of both.
    """

    first: str
    second: str
    joint: str
    rms_rad: float
    from_s: float

    @property
    def message(self) -> str:
        """One sentence for a person."""
        return (
            f"{self.first} and {self.second} have the same gains and commands and start alike, yet "
            f"{self.joint} moves differently from {self.from_s:.3g} s on (RMS difference "
            f"{self.rms_rad:.2g} rad)."
        )


def contradictions(recordings: Sequence[Recording], noise_rad: float) -> list[Contradiction]:
    """Pairs of recordings that differ by more than noise although nothing that is known does.

    Args:
        recordings: any recordings; only comparable ones are paired.
        noise_rad: standard deviation of a measured position, repeatability included.

    Returns:
        One entry a pair, for the joint with the greatest RMS difference.
    """
    # few recordings share gains, so only those that do are compared sample by sample
    groups: dict[tuple, list[Recording]] = {}
    for recording in recordings:
        groups.setdefault(_setting(recording), []).append(recording)
    return [
        found
        for group in groups.values()
        for first, second in combinations(group, 2)
        if _same_commands(first, second)
        and (found := _compare(first, second, NOISE_FACTOR * noise_rad)) is not None
    ]


def _setting(recording: Recording) -> tuple:
    return (
        recording.robot,
        recording.joints,
        tuple(recording.kp),
        tuple(recording.kd),
        recording.command_rate_hz,
        recording.control_rate_hz,
        recording.gravity_compensation,
        recording.base_position,
    )


def _same_commands(first: Recording, second: Recording) -> bool:
    """Whether commands agree over the common time, each held until its next row."""
    clocks = [recording.time - recording.time[0] for recording in (first, second)]
    edges = np.union1d(*clocks)
    edges = edges[edges <= min(clock[-1] for clock in clocks)]
    lasting = np.diff(edges) > JITTER / first.command_rate_hz
    # midpoints: at an edge itself, rounding decides which command holds
    times = (edges[:-1] + np.diff(edges) / 2)[lasting]
    held = [
        np.hstack([recording.q_des, recording.feed_forward, recording.powered])[
            np.searchsorted(clock, times, side="right") - 1
        ]
        for recording, clock in zip((first, second), clocks, strict=True)
    ]
    return len(times) > 0 and bool(np.all(np.abs(held[0] - held[1]) <= SAME_COMMAND_RAD))


def _compare(first: Recording, second: Recording, limit: float) -> Contradiction | None:
    worst = None
    for joint in range(len(first.joints)):
        times, difference = _difference(first, second, joint)
        if len(times) == 0 or abs(difference[0]) > limit:
            return None  # another start, or nothing in common: no repetition
        start = _first_run(np.abs(difference) > limit)
        if start is None:
            continue
        rms = float(np.sqrt(np.mean(difference**2)))
        if worst is None or rms > worst.rms_rad:
            worst = Contradiction(
                first.name, second.name, first.joints[joint], rms, float(times[start])
            )
    return worst


def _difference(first: Recording, second: Recording, joint: int) -> tuple[np.ndarray, np.ndarray]:
    """Measured second minus first where first was sampled, and the times from the start."""
    (t1, q1), (t2, q2) = (
        (r.time[fine] - r.time[0], r.q[fine, joint])
        for r in (first, second)
        for fine in [~np.isnan(r.q[:, joint])]
    )
    common = (t1 >= t2[0]) & (t1 <= t2[-1])
    return t1[common], np.interp(t1[common], t2, q2) - q1[common]


def _first_run(outside: np.ndarray) -> int | None:
    """Where the first `SAMPLES_IN_A_ROW` true values begin."""
    runs = np.convolve(outside, np.ones(SAMPLES_IN_A_ROW), mode="valid") == SAMPLES_IN_A_ROW
    return int(np.argmax(runs)) if runs.any() else None
