import numpy as np

from t2l.policies import Episode
from t2l.policies.windows import around, windows


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
