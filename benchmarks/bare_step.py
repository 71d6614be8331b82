"""What MuJoCo can do at most: a prediction's simulations stepped again with nothing around."""

import time
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from mujoco.batch import MODEL_FIELDS, Batch

from t2l.effects.effect import Effect
from t2l.effects.term import Layout, Term
from t2l.identify.prediction import Predictor, Request
from t2l.sim import make_batch
from t2l.sim.servo import ServoLoop


@dataclass
class Replay:
    """A batch that a prediction made, to be stepped again.

    Attributes:
        torques: for each tick (nsim, njoint) N·m that moved the joints.
    """

    loop: ServoLoop
    torques: list[np.ndarray]

    @property
    def steps(self) -> int:
        """Physics steps of all simulations."""
        return len(self.torques) * self.loop.batch.nsim * self.loop.nstep

    def prepare(self) -> Batch:
        """The same model, start, per-simulation fields and number of simulations and threads."""
        loop = self.loop
        batch = make_batch(loop.batch.model, loop.batch.nsim, loop.batch.nthread)
        for name in MODEL_FIELDS:
            if loop.batch.expanded(name) is not None:
                batch.expand(name)[:] = loop.batch.expanded(name)
        batch.qpos[:, loop.qpos] = loop.start_q - loop.encoder_offset
        batch.forward()
        return batch

    def seconds(self) -> float:
        """Of nothing but torques in and steps."""
        batch = self.prepare()
        applied, dofs, nstep = batch.qfrc_applied, self.loop.dofs, self.loop.nstep
        start = time.perf_counter()
        for torque in self.torques:
            applied[:, dofs] = torque
            batch.step(nstep=nstep)
        return time.perf_counter() - start


class Listener(Effect):
    """Changes nothing; keeps the loops it is installed in and the torques of their joints."""

    name = title = "listener"
    parameters = ()
    summary = signature = source = ""
    order = 1000  # after every other effect

    def __init__(self):
        self.replays: list[Replay] = []

    def install(self, loop, rows, joints, values):
        replay = Replay(loop, [])
        self.replays.append(replay)
        # float32 halves the memory and changes the motion by nothing that matters
        loop.joint_torques.append(
            lambda tick, q, dq, torque: replay.torques.append(torque.astype(np.float32))
        )

    def starts(self, scales):
        return [{}]


def replays(predictor: Predictor, terms: Sequence[Term], u: np.ndarray) -> list[Replay]:
    """The batches that predicting the variants u (m, n) of `terms` steps."""
    listener = Listener()
    predictor.predict([Request(Layout([*terms, Term(listener, ())]), u)])
    return listener.replays
