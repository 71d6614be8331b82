"""Some of the places of a motion, and what other bodies, gravity or encoders take there.

Inverse dynamics are linear in gravity and in the inertial parameters of bodies, and what a hinge
carries goes with sine and cosine of its angle. So a few evaluations at every place serve for all
variants of a plant:

    τ(q − o, g, π) ≈ Σ_b g_b (v_b + Y_b δπ − Σ_j (∂_j v_b + ∂_j Y_b δπ) s_j) + ½ Σ_ij ∂_ij v c_ij

over no gravity (g_0 = 1) and that along each axis, with s_j = sin o_j, c_ij = s_i s_j and
c_jj = 2 (1 − cos o_j); of a slide s_j = o_j. What three of these changes together do is left out.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import mujoco
import numpy as np
from scipy.ndimage import uniform_filter1d

from t2l.sim.regressor import inverse_dynamics, regressor

# numerics: places that inverse dynamics are evaluated at, linear between them: for the torque of
# masses, which is led along the motion, and for derivatives of the loop
PER_S, COARSE_PER_S = 250.0, 100.0
STEP_RAD = 1e-3  # numerics: of second differences


class Poses:
    """Places of a motion.

    Attributes:
        at: (npose,) their ticks, of `ntick`.
        q, dq, ddq: (npose, nrec, njoint).
    """

    def __init__(
        self,
        q: np.ndarray,
        dq: np.ndarray,
        ddq: np.ndarray,
        period_s: float,
        per_s: float = PER_S,
    ):
        """Of a motion (ntick, nrec, njoint) at ticks that are so far from each other.

        Args:
            per_s: places a second, at least one in so long.
        """
        ntick = len(q)
        every = max(1, round(1 / (per_s * period_s)))
        self.at = np.unique(np.append(np.arange(0, ntick, every), ntick - 1))
        self.ntick = ntick
        # a command makes the acceleration jump: what is between two places counts too
        ddq = uniform_filter1d(ddq, every, axis=0, mode="nearest")
        self.q, self.dq, self.ddq = (values[self.at] for values in (q, dq, ddq))
        # by identity; the model is held, so that no other takes its place
        self._known: dict[int, tuple[mujoco.MjModel, _Plant]] = {}

    def at_ticks(self, values: np.ndarray) -> np.ndarray:
        """Values (npose, …) at every tick, (ntick, …), linear between the poses, as precise."""
        ticks = np.arange(self.ntick)
        after = np.clip(np.searchsorted(self.at, ticks, side="left"), 1, len(self.at) - 1)
        gap = self.at[after] - self.at[after - 1]
        part = ((ticks - self.at[after - 1]) / gap).reshape(-1, *(1,) * (values.ndim - 1))
        found = np.diff(values, axis=0)[after - 1]
        found *= part.astype(values.dtype)
        found += values[after - 1]
        return found

    def beyond(
        self,
        model: mujoco.MjModel,
        dofs: np.ndarray,
        masses: np.ndarray | None = None,
        gravity: np.ndarray | None = None,
        offset: np.ndarray | None = None,
    ) -> np.ndarray:
        """N·m (npose, m, nrec, n) that m variants take beyond the model.

        Args:
            dofs: (n,) of the joints.
            masses: (m, nbody, 10) inertial parameters beyond the model's.
            gravity: (m, 3) m/s².
            offset: (m, nrec, n) rad, what encoders tell more than the joints' positions.
        """
        plant, total = self._plant(model, dofs), 0.0
        own = model.opt.gravity
        if gravity is not None:
            along = np.stack([plant.along(axis) for axis in range(3)])
            total = total + np.einsum("gprn,vg->pvrn", along, gravity - own)
        if masses is not None:
            total = total + _of_masses(plant.regressor(), masses)
            if gravity is not None and (gravity != own).any():
                for axis in range(3):
                    more = (gravity[:, axis] - own[axis])[:, None, None]
                    total = total + _of_masses(plant.regressor(axis), more * masses)
        if offset is not None:
            total = total + self._where_it_is(plant, masses, gravity, offset)
        return total

    def _where_it_is(self, plant: "_Plant", masses, gravity, offset: np.ndarray) -> np.ndarray:
        """What changes as joints are not where encoders tell."""
        sine = np.where(plant.turns, np.sin(offset), offset)
        square = np.where(plant.turns, 2 * (1 - np.cos(offset)), offset**2)
        both = sine[..., :, None] * sine[..., None, :]
        joints = np.arange(offset.shape[-1])
        both[..., joints, joints] = square
        slope, curvature = plant.by_angle()
        total = 0.5 * np.einsum("prnij,vrij->pvrn", curvature, both, optimize=True)
        total -= np.einsum("prnj,vrj->pvrn", slope, sine, optimize=True)
        for j in joints[sine.any(axis=(0, 1))]:
            by_joint = sine[None, :, :, j, None]
            if gravity is not None:
                more = np.stack([plant.along_by(axis, j) for axis in range(3)])
                change = gravity - plant.model.opt.gravity
                total -= by_joint * np.einsum("gprn,vg->pvrn", more, change)
            if masses is not None:
                total -= by_joint * _of_masses(plant.regressor_by(j), masses)
        return total

    def _plant(self, model: mujoco.MjModel, dofs: np.ndarray) -> "_Plant":
        if id(model) not in self._known:
            self._known[id(model)] = model, _Plant(self, model, dofs)
        return self._known[id(model)][1]


@dataclass
class _Plant:
    """What a model takes at poses, each part evaluated once when it is asked for.

    Attributes:
        turns: (n,) bool, which joints are hinges.
    """

    poses: Poses
    model: mujoco.MjModel
    dofs: np.ndarray
    _known: dict[tuple, np.ndarray | tuple] = field(default_factory=dict)

    def __post_init__(self) -> None:
        of_joint = self.model.jnt_type[self.model.dof_jntid[self.dofs]]
        self.turns = of_joint == mujoco.mjtJoint.mjJNT_HINGE

    def along(self, axis: int) -> np.ndarray:
        """(npose, nrec, n) of 1 m/s² along an axis."""
        return self._once(("along", axis), lambda: self._weight(axis))

    def along_by(self, axis: int, joint: int) -> np.ndarray:
        """The same by the position of a joint, a rad."""

        def slope():
            return (self._weight(axis, self._moved(joint)) - self.along(axis)) / STEP_RAD

        return self._once(("along", axis, joint), slope)

    def regressor(self, axis: int | None = None) -> np.ndarray:
        """Y (npose, nrec, nbody, n, 10), or what 1 m/s² along an axis adds to it."""

        def found():
            if axis is None:
                return self._regressors(self._motion())
            return self._regressors(self._at_rest(), np.eye(3)[axis])

        return self._once(("regressor", axis), found)

    def regressor_by(self, joint: int) -> np.ndarray:
        """Y by the position of a joint, a rad."""

        def slope():
            moved = self._regressors(self._motion(self._moved(joint)))
            return (moved - self.regressor()) / STEP_RAD

        return self._once(("regressor by", joint), slope)

    def by_angle(self) -> tuple[np.ndarray, np.ndarray]:
        """Derivatives (npose, nrec, n, n) and (npose, nrec, n, n, n) by positions."""

        def found():
            n = len(self.dofs)
            start, slope = self._inverse(self._motion()), []
            moved = [self._inverse(self._motion(self._moved(j))) - start for j in range(n)]
            curvature = np.empty((*start.shape, n, n))
            for i in range(n):
                for j in range(i, n):
                    far = self._inverse(self._motion(self._moved(i) + self._moved(j))) - start
                    curvature[..., i, j] = (far - moved[i] - moved[j]) / STEP_RAD**2
                    curvature[..., j, i] = curvature[..., i, j]
                slope.append(moved[i] / STEP_RAD - 0.5 * STEP_RAD * curvature[..., i, i])
            return np.stack(slope, axis=-1), curvature

        return self._once(("by angle",), found)

    def _once(self, key: tuple, evaluate: Callable):
        if key not in self._known:
            self._known[key] = evaluate()
        return self._known[key]

    def _moved(self, joint: int) -> np.ndarray:
        return STEP_RAD * np.eye(len(self.dofs))[joint]

    def _motion(self, more: np.ndarray | float = 0.0) -> list[np.ndarray]:
        """Positions that are so far on, velocities and accelerations (n, npose · nrec)."""
        poses, n = self.poses, len(self.dofs)
        return [v.reshape(-1, n).T for v in (poses.q + more, poses.dq, poses.ddq)]

    def _at_rest(self, more: np.ndarray | float = 0.0) -> list[np.ndarray]:
        q, *_ = self._motion(more)
        return [q, np.zeros_like(q), np.zeros_like(q)]

    def _weight(self, axis: int, more: np.ndarray | float = 0.0) -> np.ndarray:
        """N·m (npose, nrec, n) of 1 m/s² along an axis at positions that are so far on."""
        return self._inverse(self._at_rest(more), np.eye(3)[axis])

    def _inverse(
        self, motion: Sequence[np.ndarray], gravity: np.ndarray | None = None
    ) -> np.ndarray:
        """N·m (npose, nrec, n); under the model's own gravity if no other is given."""
        gravity = self.model.opt.gravity if gravity is None else gravity
        found = inverse_dynamics(self.model, self.dofs, motion, gravity)
        return found.T.reshape(self.poses.q.shape)

    def _regressors(
        self, motion: Sequence[np.ndarray], gravity: np.ndarray | None = None
    ) -> np.ndarray:
        """(npose, nrec, nbody, n, 10)."""
        gravity = self.model.opt.gravity if gravity is None else gravity
        found = regressor(self.model, self.dofs, motion, gravity)
        found = np.ascontiguousarray(np.moveaxis(found, -1, 0), np.float32)
        return found.reshape(*self.poses.q.shape[:2], *found.shape[1:])


def _of_masses(regressor: np.ndarray, masses: np.ndarray) -> np.ndarray:
    """N·m (npose, m, nrec, n) of inertial parameters (m, nbody, 10)."""
    masses = masses.astype(regressor.dtype)
    return np.einsum("prbnk,vbk->pvrn", regressor, masses, optimize=True)
