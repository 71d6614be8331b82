"""Forces from outside that act on the robots of a batch while they learn."""

from abc import ABC, abstractmethod

import mujoco
import numpy as np
from mujoco.batch import Batch

POINT = "force_point"  # the body of `add_point`


def add_point(spec: mujoco.MjSpec, site: str) -> None:
    """Put a body without mass at a site: a force on it (`xfrc_applied`) acts there, and not at a
    link's centre of mass.
    """
    at = spec.site(site)
    # its inertial frame must be told: the compiler moves that of a body without mass
    at.parent.add_body(name=POINT, pos=at.pos, explicitinertial=True, mass=0.0, ipos=(0, 0, 0))


class Disturbance(ABC):
    """What acts on the `n` robots of a batch, besides their controllers.

    What it remembers is in arrays that are attributes of it.
    """

    def begin(self, ids: np.ndarray) -> None:  # noqa: B027
        """Take in that robots `ids` begin an episode."""

    @abstractmethod
    def apply(self, time_s: np.ndarray) -> None:
        """Set what acts during the next policy period, (n,) s after each episode began."""

    @property
    def memory(self) -> dict[str, np.ndarray]:
        """What it remembers, by name; written in place it is another memory."""
        return {name: value for name, value in vars(self).items() if isinstance(value, np.ndarray)}


class Forces(Disturbance):
    """Forces at the point that `add_point` made, in the world's frame.

    Args:
        batch: of a model with that point.
    """

    def __init__(self, batch: Batch):
        self.n = batch.nsim
        self._wrench = batch.bind("xfrc_applied")
        self._point = batch.model.body(POINT).id

    def apply(self, time_s):
        """See `Disturbance.apply`."""
        self._wrench[:, self._point, :3] = self.force(time_s)

    @abstractmethod
    def force(self, time_s: np.ndarray) -> np.ndarray:
        """(n, 3) N."""


class RandomPushes(Forces):
    """One push in every `every_s`: its instant, length, size and direction are random.

    Args:
        most_n: the largest force, N; sizes are uniform from 0.
        length_s: shortest and longest push, s.
        every_s: the length of a window with one push in it, s, no shorter than the longest push.
    """

    def __init__(
        self,
        batch: Batch,
        generator: np.random.Generator,
        most_n: float,
        length_s: tuple[float, float],
        every_s: float,
    ):
        super().__init__(batch)
        self._generator, self._most_n = generator, most_n
        self._length_s, self._every_s = length_s, every_s
        self._window = np.full(self.n, -1)
        self._push = np.zeros((self.n, 3))
        self._from_s, self._until_s = np.zeros(self.n), np.zeros(self.n)

    def begin(self, ids):
        """See `Disturbance.begin`."""
        self._window[ids] = -1

    def force(self, time_s):
        """See `Forces.force`."""
        window = np.floor(time_s / self._every_s + 1e-9).astype(int)
        if (new := np.flatnonzero(window != self._window)).size:
            self._draw(new)
            self._window[new] = window[new]
        since = time_s - window * self._every_s
        on = (since >= self._from_s) & (since < self._until_s)
        return np.where(on[:, None], self._push, 0.0)

    def _draw(self, ids: np.ndarray) -> None:
        draw = self._generator
        size = draw.uniform(0.0, self._most_n, len(ids))
        self._push[ids] = size[:, None] * directions(draw, len(ids))
        length = draw.uniform(*self._length_s, len(ids))
        self._from_s[ids] = draw.uniform(0.0, self._every_s - length)
        self._until_s[ids] = self._from_s[ids] + length


def directions(generator: np.random.Generator, n: int) -> np.ndarray:
    """(n, 3) unit vectors, uniform on the sphere."""
    vectors = generator.normal(size=(n, 3))
    return vectors / np.linalg.norm(vectors, axis=1, keepdims=True)
