"""What to fit on and what to hold out: whole recordings, or blocks of time in a few long ones."""

from collections.abc import Sequence

import numpy as np

from t2l.errors import RecordingError
from t2l.recordings.recording import Recording

LEAST_TO_HOLD_OUT_WHOLE = 3  # statistics: recordings: of fewer none can be left out


def hold_out(
    recordings: Sequence[Recording], fraction: float, seed: int
) -> tuple[list[Recording], list[Recording]]:
    """Split into recordings to fit on and ones to hold out, spread evenly over the gains.

    Recordings are ordered by gains and cut into as many equal strata as are held out; each stratum
    gives one, at random. The order of `recordings` does not matter.

    Args:
        recordings: at least three; with fewer, use `time_blocks`.
        fraction: of the recordings to hold out, above 0 and below 1; at least one is, and at least
            one is not.
        seed: the same split for the same seed.

    Returns:
        Both parts, in the given order.

    Raises:
        ValueError: too few recordings, or an impossible fraction.
    """
    if len(recordings) < LEAST_TO_HOLD_OUT_WHOLE:
        raise ValueError(f"{len(recordings)} recordings are too few to hold out whole ones")
    if not 0 < fraction < 1:
        raise ValueError(f"fraction must be above 0 and below 1, found {fraction}")
    count = min(max(1, round(fraction * len(recordings))), len(recordings) - 1)
    ordered = sorted(
        range(len(recordings)),
        key=lambda i: (
            tuple(recordings[i].kp),
            tuple(recordings[i].kd),
            recordings[i].name,
        ),
    )
    rng = np.random.default_rng(seed)
    chosen = {int(rng.choice(stratum)) for stratum in np.array_split(ordered, count)}
    return (
        [r for i, r in enumerate(recordings) if i not in chosen],
        [r for i, r in enumerate(recordings) if i in chosen],
    )


def time_blocks(recording: Recording, block_s: float) -> np.ndarray:
    """Number the blocks of time that a recording's rows fall into; odd ones are to be held out.

    Returns:
        Integers, (n,), from 0 up; ``time_blocks(...) % 2 == 1`` is the mask of held-out rows.

    Raises:
        RecordingError: a block is longer than half the recording, so that none would be held out.
    """
    if not 0 < block_s <= recording.duration_s / 2:
        raise RecordingError(
            recording.path or recording.name,
            "the length of blocks to hold out",
            f"{block_s:g} s",
            f"above 0, up to {recording.duration_s / 2:g} s, half the recording",
        )
    elapsed = recording.time - recording.time[0]
    # a row that is on an edge up to rounding belongs to the block that begins there
    return np.floor(elapsed / block_s + 1e-9).astype(int)
