import numpy as np
import torch

from t2l.policies import Episode
from t2l.policies.windows import Windows


def test_windows_stay_in_their_episode():
    episodes = [
        Episode(np.arange(5.0)[:, None], np.arange(5.0)[:, None]),
        Episode(np.arange(100.0, 103)[:, None], np.arange(100.0, 103)[:, None]),
    ]
    windows = Windows(episodes, history=3, chunk=4, device=torch.device("cpu"))
    assert len(windows) == 8
    history, chunk = windows[torch.arange(8)]
    assert history[0, :, 0].tolist() == [0, 0, 0]
    assert history[3, :, 0].tolist() == [1, 2, 3]
    assert history[5, :, 0].tolist() == [100, 100, 100]
    assert chunk[0, :, 0].tolist() == [0, 1, 2, 3]
    assert chunk[4, :, 0].tolist() == [4, 4, 4, 4]
    assert chunk[6, :, 0].tolist() == [101, 102, 102, 102]
