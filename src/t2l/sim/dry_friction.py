"""Dry friction beside the MJCF's own.

MuJoCo gives a joint one frictionloss, as soft as its solimp and solref say: with the defaults a
joint at rest creeps. What is added to it must hold at rest, and no softness of the sum is that of
the two. So it is a constraint of its own: that of a fixed tendon over the joint alone, or the
joint's where the MJCF leaves it without friction.
"""

import mujoco
import numpy as np
from mujoco.batch import Batch

from t2l.sim.arrays import columns

HOLDS = 0.9999  # constraint impedance; MuJoCo's default of 0.9 lets a joint at rest creep


def make_room(spec: mujoco.MjSpec, joints: tuple[str, ...]) -> None:
    """Give those of `joints` that have friction an element for more."""
    for name in joints:
        if spec.joint(name).frictionloss > 0:
            spec.add_tendon(name=_element(name)).wrap_joint(name, 1.0)


def stiffen(model: mujoco.MjModel, joints: tuple[str, ...]) -> None:
    """Let what is added to the friction of `joints` hold them at rest."""
    # the stiffest that MuJoCo allows: velocity vanishes within a step
    stiffest = 2 * model.opt.timestep
    for name in joints:
        tendon, dof = _tendon(model, name), model.joint(name).dofadr[0]
        if tendon >= 0:
            model.tendon_solimp_fri[tendon, :2] = HOLDS
            model.tendon_solref_fri[tendon, 0] = stiffest
        elif model.dof_frictionloss[dof] == 0:
            model.dof_solimp[dof, :2] = HOLDS
            model.dof_solref[dof, 0] = stiffest


class AddedFriction:
    """Friction of `joints` of a batch beyond what it has now."""

    def __init__(self, batch: Batch, joints: tuple[str, ...]):
        model = batch.model
        self.dofs = columns(np.array([model.joint(name).dofadr[0] for name in joints]))
        tendons = np.array([_tendon(model, name) for name in joints])
        apart = tendons >= 0
        self.apart, self.tendons = columns(np.flatnonzero(apart)), columns(tendons[apart])
        self.joint = batch.expand("dof_frictionloss")
        self.own = self.joint[:, self.dofs].copy()
        # that is added to the joint's own
        self.most = np.full_like(self.own, np.where(apart, 0.0, np.inf))
        self.more = batch.expand("tendon_frictionloss") if apart.any() else None

    def write(self, level: np.ndarray) -> None:
        """Set it to (nsim, njoint) N·m; below zero it takes away from what there is."""
        own = np.minimum(level, self.most)
        own += self.own
        self.joint[:, self.dofs] = np.maximum(own, 0.0, out=own)
        if self.more is not None:
            self.more[:, self.tendons] = np.maximum(level[:, self.apart], 0.0)


def _element(joint: str) -> str:
    return f"{joint}/friction"


def _tendon(model: mujoco.MjModel, joint: str) -> int:
    return mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_TENDON, _element(joint))
