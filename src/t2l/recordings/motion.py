"""Whether recordings hold anything that a model could be fitted to."""

from collections.abc import Sequence

import numpy as np

from t2l.errors import RecordingError
from t2l.recordings.checks import COMMANDED
from t2l.recordings.recording import Recording

STILL_RAD = 1e-9  # numerics: no encoder is finer


def check_motion(recordings: Sequence[Recording]) -> None:
    """Whether anything is asked of the machine, or happens to it, that a model could be fitted to.

    Raises:
        RecordingError: no command and no position of any joint differs from its first.
    """
    for signal in (COMMANDED, "q"):
        values = np.concatenate([getattr(recording, signal) for recording in recordings])
        if (np.nanmax(values, axis=0) - np.nanmin(values, axis=0) > STILL_RAD).any():
            return
    first = recordings[0]
    raise RecordingError(
        first.path or first.name,
        f"columns {COMMANDED}.* and q.*" + (" of all recordings" if len(recordings) > 1 else ""),
        "the same number in every row",
        "recordings in which a joint moves, or is held at several places",
    )
