"""The steps that a chain asked of its batch, to be stepped again with nothing around them."""

import contextlib
from collections.abc import Iterator
from dataclasses import dataclass
from unittest import mock

import numpy as np
from mujoco.batch import MODEL_FIELDS, Batch

from t2l.sim import make_batch

# where batches are made that demonstrations and policies are replayed and rolled out in
MADE_IN = "t2l.environment.episodes.make_batch"


class Recording(Batch):
    """A batch that remembers what each of its steps was given."""

    def __init__(self, batch: Batch):
        super().__init__(batch.model, batch.nsim, batch.nthread, batch.persistent)
        self.steps: list[tuple[np.ndarray, int]] = []
        self.start = self.state

    def step(self, ids=None, nstep=1, **more):
        """See `Batch.step`."""
        if not self.steps:
            self.start = self.state.copy()
        self.steps.append((self.ctrl.copy(), nstep))
        super().step(ids=ids, nstep=nstep, **more)


@dataclass(frozen=True)
class Steps:
    """Of a batch, from its start on.

    Attributes:
        batch: that took them, with its per-simulation fields.
    """

    batch: Recording

    @property
    def count(self) -> int:
        """Physics steps of all simulations."""
        return self.batch.nsim * sum(nstep for _, nstep in self.batch.steps)

    def again(self) -> None:
        """Nothing but controls in and steps: what MuJoCo can do at most on these motions."""
        batch = make_batch(self.batch.model, self.batch.nsim, self.batch.nthread)
        for name in MODEL_FIELDS:
            if self.batch.expanded(name) is not None:
                batch.expand(name)[:] = self.batch.expanded(name)
        batch.state[:] = self.batch.start
        ctrl = batch.bind("ctrl")
        for controls, nstep in self.batch.steps:
            ctrl[:] = controls
            batch.step(nstep=nstep)


@contextlib.contextmanager
def recorded() -> Iterator[list[Steps]]:
    """What the batches step that a chain makes meanwhile."""
    made: list[Steps] = []

    def make(model, nsim, threads=1, **more):
        made.append(Steps(Recording(make_batch(model, nsim, threads, **more))))
        return made[-1].batch

    with mock.patch(MADE_IN, make):
        yield made
