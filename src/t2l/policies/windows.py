"""Training windows: the observation history before a step and the action chunk from it on."""

from collections.abc import Sequence

import numpy as np
import torch

from t2l.policies.policy import Episode


class Windows:
    """All windows of some episodes, gathered by index so that none is stored twice.

    History before an episode's first step repeats that step; a chunk past its last step repeats
    that one.
    """

    def __init__(self, episodes: Sequence[Episode], history: int, chunk: int, device: torch.device):
        lengths = [len(e.action) for e in episodes]
        first = np.repeat(np.cumsum([0, *lengths[:-1]]), lengths)[:, None]
        last = np.repeat(np.cumsum(lengths) - 1, lengths)[:, None]
        now = np.arange(sum(lengths))[:, None]
        past = np.maximum(now + np.arange(1 - history, 1), first)
        future = np.minimum(now + np.arange(chunk), last)
        self._past = torch.as_tensor(past, device=device)
        self._future = torch.as_tensor(future, device=device)
        self.observation = _stacked([e.observation for e in episodes], device)
        self.action = _stacked([e.action for e in episodes], device)

    def __len__(self) -> int:
        return len(self._past)

    def __getitem__(self, index: torch.Tensor) -> tuple[torch.Tensor, torch.Tensor]:
        """Histories (n, history, nobs) and chunks (n, chunk, nact)."""
        return self.observation[self._past[index]], self.action[self._future[index]]


def _stacked(arrays: list[np.ndarray], device: torch.device) -> torch.Tensor:
    return torch.as_tensor(np.concatenate(arrays), dtype=torch.float32, device=device)
