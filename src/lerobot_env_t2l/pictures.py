"""Pictures of episodes for the videos of lerobot, which shows the first few of many."""

from collections.abc import Sequence
from typing import overload

import numpy as np

from t2l.bc.episodes import PolicyEpisodes
from t2l.tasks import Demonstrated


class Pictures(Sequence[np.ndarray]):
    """One of each episode, as it is now; it is drawn when it is taken, and held for a while.

    Args:
        every: so many actions a new one is drawn, and when an episode ends; 0: only then.
    """

    def __init__(self, task: Demonstrated, n: int, every: int):
        self._task, self._n, self._every = task, n, every
        self._painter = None

    def begin(self, episodes: PolicyEpisodes) -> None:
        """Show other episodes from now on."""
        self._episodes, self._held = episodes, {}

    def follow(self, moved: np.ndarray) -> None:
        """The episodes in the mask `moved` (n,) have changed."""
        due = self._every > 0 and self._episodes.tick % self._every == 0
        for i in np.flatnonzero(moved & (due | ~self._episodes.running)):
            self._held.pop(i, None)

    def __len__(self) -> int:
        return self._n

    @overload
    def __getitem__(self, index: int) -> np.ndarray: ...
    @overload
    def __getitem__(self, index: slice) -> list[np.ndarray]: ...
    def __getitem__(self, index):
        chosen = range(self._n)[index]
        return [self._drawn(i) for i in chosen] if isinstance(index, slice) else self._drawn(chosen)

    def _drawn(self, i: int) -> np.ndarray:
        if i not in self._held:
            if self._painter is None:
                # it imports matplotlib, and compiles the scene with its meshes
                from t2l.figures.frames import Painter

                self._painter = Painter(self._task, shadows=False)
            self._held[i] = self._painter.draw(self._episodes.qpos[i])
        return self._held[i]

    def close(self) -> None:
        """Release what draws."""
        if self._painter is not None:
            self._painter.close()
