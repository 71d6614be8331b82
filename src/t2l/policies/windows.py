"""Training windows: the observation history before a step and the action chunk from it on."""

from collections.abc import Sequence

import numpy as np

from t2l.policies.policy import Episode, Pictures


def windows(
    episodes: Sequence[Episode], history: int, chunk: int
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Every step of some episodes, and which steps are before and after it.

    History before an episode's first step repeats that step; a chunk past its last step repeats
    that one.

    Returns:
        Observation (n, nobs) and action (n, nact) of all steps of all episodes, and for each step
        the indices of its history (n, history) and of its chunk (n, chunk) among them.
    """
    lengths = [len(e.action) for e in episodes]
    first = np.repeat(np.cumsum([0, *lengths[:-1]]), lengths)[:, None]
    last = np.repeat(np.cumsum(lengths) - 1, lengths)[:, None]
    now = np.arange(sum(lengths))[:, None]
    return (
        np.concatenate([e.observation for e in episodes]),
        np.concatenate([e.action for e in episodes]),
        np.maximum(now + np.arange(1 - history, 1), first),
        np.minimum(now + np.arange(chunk), last),
    )


def pictured(episodes: Sequence[Episode]) -> Pictures | None:
    """The pictures of all steps of all episodes, in the store that they share; None without any.

    Raises:
        ValueError: some have pictures and some none, or they are of different stores.
    """
    pictures = [e.pictures for e in episodes if e.pictures is not None]
    if not pictures:
        return None
    store = pictures[0].store
    if len(pictures) < len(episodes) or any(p.store is not store for p in pictures):
        raise ValueError("episodes of which all have pictures of one store, or none has")
    return Pictures(store, np.concatenate([p.frames for p in pictures]))
