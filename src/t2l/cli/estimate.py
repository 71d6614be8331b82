"""How long a command will take, by a short simulation of its recordings, said before it begins."""

import math
import time
from collections.abc import Sequence

from t2l.identify.model import Model
from t2l.recordings.recording import Recording

TRIED = {"compare": 1}  # numerics: variants that are timed
TRIED_ELSE = 4  # numerics: likewise, of a command that tries many
TIMED_S = 10.0  # numerics: of each recording, of which more is not simulated to be timed
# measured, least and most: times that every candidate on each joint is simulated once, by command,
# in five rounds on robots of two to seven joints: after one round or after three
ROUNDS = {
    "compare": (1, 2),
    "diagnose": (1.5, 6),
    "explain": (1.5, 12),
    "propose": (1.5, 12),
}
UNITS = ((200.0, 1.0, "s"), (6000.0, 60.0, "minutes"), (math.inf, 3600.0, "h"))
PAGE_S = {
    "compare": 4,
    "diagnose": 5,
    "explain": 6,
    "propose": 5,
}  # measured: figures and pages


def say_how_long(
    command: str,
    model: Model,
    recordings: Sequence[Recording],
    substeps: int | None = None,
    threads: int | None = None,
    at_most_s: float | None = None,
) -> None:
    """Print about how long a command takes with these recordings on this machine.

    Args:
        substeps: of a tick, where the command has found out how many the model needs.
        at_most_s: after which it ends what it searches.
    """
    from t2l.identify.prediction import Predictor
    from t2l.identify.step_size import substeps_for

    substeps = substeps or substeps_for(model, recordings)
    predictor = Predictor(model.robot, recordings, substeps, threads)
    low, high = estimated_s(command, model, predictor)
    cores = predictor.threads
    limit = f", the search no longer than {at_most_s:g} s" if at_most_s else ""
    print(
        f"This takes about {duration(low, high)} on this machine ({cores} "
        f"core{'s' if cores > 1 else ''}){limit}.",
        flush=True,
    )


def estimated_s(command: str, model: Model, predictor) -> tuple[float, float]:
    """The least and the most seconds that a command is likely to take."""
    import numpy as np

    from t2l.identify.prediction import Request
    from t2l.identify.step_size import busiest

    layout, u = model.vector(predictor.joints)
    # of long recordings all cannot be simulated only to say how long it takes
    asked = predictor.of([busiest(r, TIMED_S) for r in predictor.recordings])
    tried = TRIED.get(command, TRIED_ELSE)
    longer = sum(_length(predictor)) / max(sum(_length(asked)), 1e-9)
    began = time.perf_counter()
    asked.predict([Request(layout, np.repeat(u[None], tried, axis=0))])
    once = longer * (time.perf_counter() - began) / tried
    candidates = len(model.missing_effects(predictor.joints, predictor.recordings))
    return likely_s(command, once, candidates, len(predictor.joints))


def _length(predictor) -> list[float]:
    return [recording.duration_s for recording in predictor.recordings]


def likely_s(command: str, once_s: float, candidates: int, joints: int = 1) -> tuple[float, float]:
    """Likewise, from the time that one variant takes and the number of effects to try."""
    least, most = ROUNDS[command]
    work = once_s if command == "compare" else once_s * candidates * joints
    return PAGE_S[command] + least * work, 2 * PAGE_S[command] + most * work


def duration(low_s: float, high_s: float) -> str:
    """Two times in the unit that suits the longer one: "20 to 50 s", "3 to 8 minutes"."""
    unit, words = next((u, w) for most, u, w in UNITS if high_s < most)
    low, high = _rounded(low_s / unit), _rounded(high_s / unit)
    return f"{max(low, 1)} to {max(high, low + 1, 2)} {words}"


def _rounded(number: float) -> int:
    """To a whole number, of tens in tens."""
    return int(round(number, -1 if number >= 20 else 0))
