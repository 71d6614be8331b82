"""Names by which recordings of several folders are told apart."""

from collections.abc import Sequence

from t2l.recordings.recording import Recording


def unique_names(recordings: Sequence[Recording]) -> tuple[str, ...]:
    """A name a recording, with its folder or a number where the file's name is not enough."""
    names = [recording.name for recording in recordings]
    if len(set(names)) < len(names):
        names = [f"{r.path.parent.name}/{r.name}" if r.path else r.name for r in recordings]
    counts: dict[str, int] = {}
    unique = []
    for name in names:
        counts[name] = counts.get(name, 0) + 1
        unique.append(name if counts[name] == 1 else f"{name} ({counts[name]})")
    return tuple(unique)
