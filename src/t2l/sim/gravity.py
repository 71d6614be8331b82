"""Gravity compensation as a control loop gives it: computed at its ticks and held between them.

The torque that carries the weights m_i is ∂V/∂q_j = −Σ m_i g · ∂x_i/∂q_j. For a hinge with axis a
through p, ∂x_i/∂q_j = a × (x_i − p), and for a slide it is a. The masses are those of the model
as it is compiled: a controller knows no others.
"""

import mujoco
import numpy as np
from mujoco.batch import Batch

from t2l.sim.arrays import columns


class GravityCompensation:
    """The compensation of `joints` of a batch at the present tick, N·m.

    MuJoCo leaves the places of masses where the last physics step evaluated its forces. From there
    the torque is extended to the tick in proportion to how it changed since the tick before.
    """

    def __init__(self, batch: Batch, joints: tuple[str, ...]):
        self.batch, model = batch, batch.model
        self.model = model
        ids = [model.joint(name).id for name in joints]
        bodies = model.jnt_bodyid[ids]
        weights = model.body_mass * model.body_gravcomp
        carried = np.array([[_carries(model, b, i) for i in range(model.nbody)] for b in bodies])
        carried = carried * weights
        slides = model.jnt_type[ids] == mujoco.mjtJoint.mjJNT_SLIDE
        hinges = ~slides[:, None]
        # of the flat places (3 nbody), anchors and axes (3 njnt): one product each, every tick
        chosen, mass = np.eye(model.njnt)[:, ids], carried.sum(axis=1)
        turn = np.cross(np.eye(3), -model.opt.gravity)  # takes x to gravity × x
        self.places = np.kron((carried * hinges).T, turn)
        self.mass = np.kron(chosen * (mass * ~slides), turn)
        self.along = np.kron(chosen * (mass * slides), model.opt.gravity[:, None])
        self.total = np.kron(np.eye(len(ids)), np.ones((3, 1)))
        self.of_joints = columns(np.ravel(3 * np.array(ids)[:, None] + np.arange(3)))
        self.slides = slides.any()
        self.masses, self.anchors, self.axes = (
            batch.bind(name).reshape(batch.nsim, -1) for name in ("xipos", "xanchor", "xaxis")
        )
        self.shift = self._shift(carried.any(axis=0))
        self.turned = None if self.shift is None else batch.bind("xmat")
        self.last: np.ndarray | None = None

    def __call__(self, ahead: np.ndarray | float) -> np.ndarray:
        """(nsim, njoint) as of some time after the places of masses, N·m.

        Args:
            ahead: that time over the time since the last call; (nsim, 1), or one for all.
        """
        masses = self.masses
        if self.shift is not None:
            turned = self.turned.reshape(*self.shift.shape, 3)
            masses = masses + (turned @ self.shift[..., None]).reshape(masses.shape)
        # of few simulations `dot` takes less than half of the time of @
        moment = masses.dot(self.places)
        moment -= self.anchors.dot(self.mass)
        moment *= self.axes[:, self.of_joints]
        torque = moment.dot(self.total)
        if self.slides:
            torque -= self.axes.dot(self.along)
        last, self.last = self.last, torque
        return torque if last is None else torque + (torque - last) * ahead

    def _shift(self, weighty: np.ndarray) -> np.ndarray | None:
        """From real to modelled centres of mass, (nsim, nbody, 3) m; None if they are the same."""
        real = self.batch.expanded("body_ipos")
        if real is None:
            return None
        shift = (self.model.body_ipos - real) * weighty[:, None]
        return shift if shift.any() else None


def _carries(model: mujoco.MjModel, body: int, other: int) -> bool:
    """Whether `other` is `body` or hangs on it."""
    while other > body:
        other = model.body_parentid[other]
    return other == body
