from dataclasses import replace

import numpy as np
import pytest

from t2l.policies import Episode
from t2l.policies.windows import around, stored, together, windows


def test_windows_stay_in_their_episode():
    episodes = [
        Episode(np.arange(5.0)[:, None], np.arange(5.0)[:, None]),
        Episode(np.arange(100.0, 103)[:, None], np.arange(100.0, 103)[:, None]),
    ]
    observation, action, past, future = windows(episodes, history=3, chunk=4)
    assert len(past) == len(future) == 8
    history, chunk = observation[past, 0], action[future, 0]
    assert history[0].tolist() == [0, 0, 0]
    assert history[3].tolist() == [1, 2, 3]
    assert history[5].tolist() == [100, 100, 100]
    assert chunk[0].tolist() == [0, 1, 2, 3]
    assert chunk[4].tolist() == [4, 4, 4, 4]
    assert chunk[6].tolist() == [101, 102, 102, 102]


def test_steps_that_an_episode_does_not_have_are_told():
    index, beyond = around([3, 2], [-1, 0, 2])
    assert index.tolist() == [[0, 0, 2], [0, 1, 2], [1, 2, 2], [3, 3, 4], [3, 4, 4]]
    assert beyond.tolist() == [
        [True, False, False],
        [False, False, True],
        [False, False, True],
        [True, False, True],
        [False, False, True],
    ]


def numbered(*lengths):
    """Episodes that count on from one to the next."""
    steps = np.arange(2.0 * sum(lengths)).reshape(-1, 2).astype(np.float32)
    cuts = np.cumsum(lengths)[:-1]
    return [Episode(s.copy(), -s[:, :1]) for s in np.split(steps, cuts)]


def test_episodes_that_lie_together_are_stored_without_a_copy():
    apart = numbered(5, 3, 4)
    joined = together(apart)
    for one, other in zip(joined, apart, strict=True):
        np.testing.assert_array_equal(one.observation, other.observation)
        np.testing.assert_array_equal(one.action, other.action)
    observation, action, begins = stored([joined[2], joined[0]])
    assert begins == [8, 0]
    assert np.shares_memory(observation, joined[0].observation)
    assert np.shares_memory(action, joined[2].action)
    np.testing.assert_array_equal(observation[8:], apart[2].observation)


@pytest.mark.parametrize(
    "change",
    [
        lambda e: replace(e, observation=e.observation.copy()),
        lambda e: replace(e, action=e.action.copy()),
        lambda e: replace(e, observation=e.observation[::2], action=e.action[::2]),
        lambda e: replace(e, observation=e.observation[:, :1]),
    ],
    ids=["observations", "actions", "every second", "columns"],
)
def test_what_does_not_lie_together_is_copied_together(change):
    first, second, _ = together(numbered(6, 3, 4))
    given = [change(first), change(second)]
    observation, action, begins = stored(given)
    assert begins == [0, len(given[0].action)]
    np.testing.assert_array_equal(observation, np.concatenate([e.observation for e in given]))
    np.testing.assert_array_equal(action, np.concatenate([e.action for e in given]))
