"""A learned torque while it is fitted: a sum of basis functions, with weights as parameters."""

import numpy as np

from t2l.effects.armature import LIGHTEST, add_armature
from t2l.effects.effect import Effect, Parameter
from t2l.effects.law import HYSTERESIS, INERTIA, PHASE, SIGNED, TENDON, Law
from t2l.effects.learned import LearnedTorque, looked_up, order, yielding

# of a period: a thousandth over a hundred periods is a tenth of one
STRETCH = Parameter("stretch", "1", -0.1, 0.1, "of the period, as a share", size=1e-3)
# bound: of a ratio, of one sign: beyond, a tendon acts on one joint
LEAST_RATIO, MOST_RATIO = 1e-3, 1e3
RATIO_SIZE = 0.3  # numerics: as of the coupling of two joints


class SplineTorque(Effect):
    """A law as a sum of basis functions whose weights are fitted.

    Of a curve over a phase the period is fitted too, as the last parameter: its stretch. Of a
    tendon it is the change of the ratio.

    Args:
        law: what acts where.
        grid: (g,) values of the variable, equally spaced; the radii of a hysteresis.
        basis: (g, k) the basis functions there; for a hysteresis the identity.
        size: of a torque that makes a difference, in the law's `torque_unit`.
        shown: ends of the variable in the recordings; by default those of the grid.
        atoms: (a, k) weights at one of which a fit begins, of a law that is not zero at first.
        ratio: of the lever arms of a tendon, as of `Curve`.
    """

    title = "learned torque"
    summary = LearnedTorque.summary
    signature = LearnedTorque.signature
    source = LearnedTorque.source

    def __init__(
        self,
        law: Law,
        grid: np.ndarray,
        basis: np.ndarray,
        size: float,
        shown: tuple[float, float] | None = None,
        atoms: np.ndarray | None = None,
        ratio: float = 0.0,
    ):
        self.law, self.grid, self.basis, self.atoms = law, grid, basis, atoms
        self.ratio = ratio
        self.shown = shown or (float(grid[0]), float(grid[-1]))
        self.name, self.needs, self.order = law.name, law.needs, order(law)
        # bound: more than any motor gives
        least, unit = -1e6 if law.kind in SIGNED else 0.0, law.torque_unit or "1"
        self.parameters = tuple(
            Parameter(f"weight_{k}", unit, least, 1e6, "of a basis function", size=size)
            for k in range(basis.shape[1])
        )
        if law.follows == PHASE:
            self.parameters = (*self.parameters, STRETCH)
        if law.kind == TENDON:
            # of one sign: a ratio of zero is no tendon
            ends = np.sort(np.sign(ratio) * np.array([LEAST_RATIO, MOST_RATIO])) - ratio
            change = "by which that of the lever arms changes"
            own = Parameter("ratio", "1", *ends.tolist(), change, size=RATIO_SIZE)
            self.parameters = (*self.parameters, own)

    def starts(self, scales):
        return [{p.name: np.zeros(len(scales.torque)) for p in self.parameters}]

    def install(self, loop, rows, joints, values):
        count = self.basis.shape[1]
        weights = np.concatenate([values[p.name] for p in self.parameters[:count]], axis=1)
        stretch = values[STRETCH.name][:, 0] if self.law.follows == PHASE else 0.0
        ratio = self.ratio + values["ratio"][:, 0] if self.law.kind == TENDON else 0.0
        if self.law.kind == HYSTERESIS:
            yielding(loop, rows, self.law, self.grid, weights)
        elif self.law.kind == INERTIA:
            per_weight = np.ptp(self.basis[:, 0]) / np.ptp(self.grid)
            add_armature(loop, rows, joints, per_weight * weights, LIGHTEST)
        else:
            looked_up(loop, rows, self.law, self.grid, weights @ self.basis.T, stretch, ratio)
