"""Gravity compensation as a control loop gives it: computed at its ticks and held between them.

The torque that carries the weights m_i is ∂V/∂q_j = −Σ m_i g · ∂x_i/∂q_j. For a hinge with axis a
through p, ∂x_i/∂q_j = a × (x_i − p), and for a slide it is a. The masses are those of the model
as it is compiled: a controller knows no others.
"""

import mujoco
import numpy as np
from mujoco.batch import Batch


class GravityCompensation:
    """The compensation of `joints` of a batch at the present tick, N·m.

    MuJoCo leaves the places of masses where the last physics step evaluated its forces. From there
    the torque is extended to the tick in proportion to how it changed since the tick before.
    """

    def __init__(self, batch: Batch, joints: tuple[str, ...]):
        model = batch.model
        ids = [model.joint(name).id for name in joints]
        self.ids, bodies = ids, model.jnt_bodyid[ids]
        weights = model.body_mass * model.body_gravcomp
        self.moved = np.array([[_carries(model, b, i) for i in range(model.nbody)] for b in bodies])
        self.moved = self.moved * weights
        self.mass = self.moved.sum(axis=1)[:, None]
        self.slides = model.jnt_type[ids] == mujoco.mjtJoint.mjJNT_SLIDE
        self.gravity = model.opt.gravity
        self.masses, self.anchors, self.axes = (
            batch.bind(name) for name in ("xipos", "xanchor", "xaxis")
        )
        self.last: np.ndarray | None = None

    def __call__(self, since_s: float, ahead_s: np.ndarray | float) -> np.ndarray:
        """(nsim, njoint) as of `ahead_s` after the places of masses, N·m.

        Args:
            since_s: from where the masses were at the last call to where they are now.
            ahead_s: (nsim, 1) or one for all.
        """
        axes = self.axes[:, self.ids]
        arms = self.moved @ self.masses - self.mass * self.anchors[:, self.ids]
        torque = -np.einsum("sjk,sjk->sj", np.cross(self.gravity, axes), arms)
        if self.slides.any():
            force = -self.mass[:, 0] * (axes @ self.gravity)
            torque = np.where(self.slides, force, torque)
        last, self.last = self.last, torque
        return torque if last is None else torque + (torque - last) * (ahead_s / since_s)


def _carries(model: mujoco.MjModel, body: int, other: int) -> bool:
    """Whether `other` is `body` or hangs on it."""
    while other > body:
        other = model.body_parentid[other]
    return other == body
