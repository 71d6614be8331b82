"""What networks are trained on, on a device: every step once, windows gathered when asked for."""

from collections.abc import Sequence

import numpy as np
import torch
from torch import Tensor

from t2l.policies.policy import Episode
from t2l.policies.training_settings import TrainingSettings
from t2l.policies.validation import AT_ONCE, PICTURED_AT_ONCE
from t2l.policies.windows import stored


class Rows:
    """The steps of episodes, a row each, which all networks share that learn from some of them.

    An episode that is given more than once, as to the training seeds of a cell, has its rows once.
    Indices of rows have 32 bits: they are all that a network adds.

    Args:
        store: on the device, of the episodes' pictures, if they have some.

    Attributes:
        observation, action: (n, nobs) and (n, nact) float32.
    """

    def __init__(
        self,
        episodes: Sequence[Episode],
        settings: TrainingSettings,
        device: torch.device,
        store: Tensor | None = None,
    ):
        # the order of a set would differ from run to run
        own = list(dict.fromkeys(episodes))
        observation, action, begins = stored(own)
        self.observation, self.action = (
            torch.as_tensor(values, dtype=torch.float32, device=device)
            for values in (observation, action)
        )
        self._rows, span = {}, np.zeros((2, len(action)), np.int32)
        frames = np.zeros(len(action), int)
        for episode, begin in zip(own, begins, strict=True):
            end = begin + len(episode.action)
            self._rows[episode] = np.arange(begin, end, dtype=np.int32)
            span[:, begin:end] = [[begin], [end - 1]]
            if store is not None:
                frames[begin:end] = episode.pictures.frames
        self._store = store
        self._first, self._last, self._frames, self._past, self._future = (
            torch.as_tensor(numbers, device=device)
            for numbers in (
                *span,
                frames,
                np.arange(1 - settings.history, 1, dtype=np.int32),
                np.arange(settings.chunk, dtype=np.int32),
            )
        )

    def of(self, episodes: Sequence[Episode]) -> Tensor:
        """(n,) int32 the rows of some of the episodes, in their order."""
        rows = np.concatenate([self._rows[e] for e in episodes])
        return torch.as_tensor(rows, device=self.observation.device)

    def __getitem__(self, index: Tensor) -> tuple[Tensor, Tensor]:
        """Histories (…, history, nobs) and chunks (…, chunk, nact) of rows (…).

        Beyond an episode's first and last step they repeat that one.
        """
        step, first, last = (
            rows.unsqueeze(-1) for rows in (index, self._first[index], self._last[index])
        )
        past = torch.maximum(step + self._past, first)
        future = torch.minimum(step + self._future, last)
        return self.observation[past], self.action[future]

    def pictures(self, index: Tensor) -> dict[str, Tensor]:
        """Nothing, or `pictures` (…, ncamera, height, width, 3) of rows (…)."""
        return {} if self._store is None else {"pictures": self._store[self._frames[index]]}

    @property
    def at_once(self) -> int:
        """Rows that are judged at once."""
        return AT_ONCE if self._store is None else PICTURED_AT_ONCE
