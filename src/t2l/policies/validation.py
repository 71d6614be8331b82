"""What a policy is judged by before it acts: demonstrations that it has not seen."""

from collections.abc import Sequence

import numpy as np

from t2l.policies.policy import Episode, Policy
from t2l.policies.windows import pictured, windows

# histories that a policy is shown at once, some 10 MB; with pictures, some 100 MB in its layers
AT_ONCE, PICTURED_AT_ONCE = 4096, 128


def split(
    episodes: Sequence[Episode], fraction: float, seed: int
) -> tuple[list[Episode], list[Episode]]:
    """Episodes to train on, and at least one that is held out.

    Raises:
        ValueError: fewer than two episodes.
    """
    if len(episodes) < 2:
        raise ValueError(f"{len(episodes)} episodes cannot be split into training and validation")
    held_out = max(1, round(fraction * len(episodes)))
    order = np.random.default_rng(seed).permutation(len(episodes))
    return [episodes[i] for i in order[held_out:]], [episodes[i] for i in order[:held_out]]


def prediction_mse(
    policy: Policy, episodes: Sequence[Episode], at_most: int | None = None
) -> np.ndarray:
    """Mean squared error of each element of the action, (nact,), in its unit squared.

    The mean is over the episodes' steps and over the chunk that the policy answers with at each;
    its square root over the joints is ε_π of the study's corollary (App. A).

    Args:
        at_most: steps, evenly spread over the episodes'; all without it.
    """
    observation, action, past, future = windows(episodes, policy.history, policy.chunk)
    pictures = pictured(episodes)
    frames = None if pictures is None else pictures.frames
    if at_most and at_most < len(past):
        judged = np.linspace(0, len(past) - 1, at_most).astype(int)
        past, future = past[judged], future[judged]
        frames = None if frames is None else frames[judged]
    at_once = AT_ONCE if pictures is None else PICTURED_AT_ONCE
    total = np.zeros(action.shape[1])
    for start in range(0, len(past), at_once):
        rows = slice(start, start + at_once)
        seen = () if pictures is None else (pictures.store[frames[rows]],)
        error = policy.act(observation[past[rows]], *seen) - action[future[rows]]
        total += (error.astype(float) ** 2).mean(axis=1).sum(axis=0)
    return total / len(past)
