"""Training windows: the observation history before a step and the action chunk from it on."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from t2l.policies.policy import Episode, Pictures


def around(lengths: Sequence[int], offsets: Sequence[int]) -> tuple[np.ndarray, np.ndarray]:
    """Which steps lie at some offsets from each step of episodes that follow one another.

    Args:
        lengths: steps of each episode.
        offsets: in steps, negative ones before.

    Returns:
        (n, noffset) indices of steps, an episode's first or last for those beyond it, and (n,
        noffset) whether it is beyond.
    """
    first = np.repeat(np.cumsum([0, *lengths[:-1]]), lengths)[:, None]
    last = np.repeat(np.cumsum(lengths) - 1, lengths)[:, None]
    wanted = np.arange(sum(lengths))[:, None] + np.asarray(offsets)
    index = np.clip(wanted, first, last)
    return index, index != wanted


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
    return (
        np.concatenate([e.observation for e in episodes]),
        np.concatenate([e.action for e in episodes]),
        around(lengths, range(1 - history, 1))[0],
        around(lengths, range(chunk))[0],
    )


def together(episodes: Sequence[Episode]) -> list[Episode]:
    """The same episodes as slices of one array of observations and one of actions."""
    cuts = np.cumsum([len(e.action) for e in episodes])[:-1]
    seen, done = (
        np.split(np.concatenate(parts), cuts)
        for parts in ([e.observation for e in episodes], [e.action for e in episodes])
    )
    return [
        replace(e, observation=observation, action=action)
        for e, observation, action in zip(episodes, seen, done, strict=True)
    ]


def stored(episodes: Sequence[Episode]) -> tuple[np.ndarray, np.ndarray, list[int]]:
    """Arrays of observations and of actions with all the steps, and where each episode begins.

    Nothing is copied if they are slices of such arrays already, as `together` makes them; there may
    be more in these.
    """
    seen, done = [e.observation for e in episodes], [e.action for e in episodes]
    begins = _begins(seen)
    if begins is not None and begins == _begins(done):
        return seen[0].base, done[0].base, begins
    ends = np.cumsum([len(action) for action in done]).tolist()
    return np.concatenate(seen), np.concatenate(done), [0, *ends[:-1]]


def _begins(parts: Sequence[np.ndarray]) -> list[int] | None:
    """Rows at which the parts begin of the one array that they are slices of, if they are."""
    whole = parts[0].base
    if not isinstance(whole, np.ndarray) or any(
        p.base is not whole or (p.shape[1:], p.strides) != (whole.shape[1:], whole.strides)
        for p in parts
    ):
        return None
    return [(p.ctypes.data - whole.ctypes.data) // whole.strides[0] for p in parts]


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
