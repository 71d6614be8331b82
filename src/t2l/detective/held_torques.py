"""What a recording begins with that no encoder sees: a torque held by what remembers.

Bristles, or an integral, of a machine in motion hold a torque at the start that nobody knows. It
fades as the joint moves, or stays. To first order it moves positions by a column of its own, which
is free in every fit: it is taken off the residual of each recording (variable projection: Golub
and Pereyra, 1973), as a simulation is begun anew for each variant (`t2l.identify.hidden_state`).
"""

from collections.abc import Sequence

import numpy as np

from t2l.detective.linear_loop import Section, respond
from t2l.effects.blame import blaming
from t2l.effects.term import Layout, Term
from t2l.identify.prediction import Predictor
from t2l.identify.simulation import install
from t2l.sim.driven_loop import DrivenLoop


class HeldTorques:
    """Takes off what a torque that is held at the start may explain.

    Args:
        predictor: of the samples.
        sections: the loop along the motion.
        place: (nsample,) of each sample of the predictor, among the fitted ones; -1 if it is none.
        noise_rad: of a sample.
    """

    def __init__(
        self,
        predictor: Predictor,
        sections: Sequence[Section],
        place: np.ndarray,
        noise_rad: float,
    ):
        self.predictor, self.sections = predictor, sections
        self.place, self.noise_rad = place, noise_rad
        period = (section.motion.group.schedule.period_s for section in sections)
        self.way = [
            np.cumsum(np.abs(section.path.dq), axis=0) * period_s
            for section, period_s in zip(sections, period, strict=True)
        ]

    def freed(self, layout: Layout, points: np.ndarray, residual: np.ndarray) -> np.ndarray:
        """Residuals (m, nsample) of points (m, n), less what the start may explain."""
        holding = [term for term in layout.terms if term.effect.holds_torque]
        if not holding:
            return residual
        values, residual = layout.decode(points), residual.copy()
        held = [(term, *term.effect.held(values[term.effect.name])) for term in holding]
        for k in range(len(self.sections)):
            self._free(k, held, self._friction(k, layout, points[:1]), residual)
        return residual

    def _friction(self, k: int, layout: Layout, u: np.ndarray) -> np.ndarray:
        """N·m (nrec, njoint) that friction of a model u (1, n) holds at rest."""
        section = self.sections[k]
        model, schedule = self.predictor.model(layout.terms), section.motion.group.schedule
        loop = DrivenLoop(model, self.predictor.joints, schedule, 1)
        with blaming([term.effect for term in layout.terms], "to lead it"):
            install(loop, [(layout, u)])
            return loop.friction_at_rest(section.path.load[0])

    def _free(
        self,
        k: int,
        held: Sequence[tuple[Term, np.ndarray, np.ndarray]],
        friction: np.ndarray,
        residual: np.ndarray,
    ) -> None:
        group = self.sections[k].motion.group
        place, recording = self.place[group.held], group.wanted[0]
        joints = np.array([joint for term, *_ in held for joint in term.joints])
        rests = np.concatenate([[t.effect.holds_at_rest] * len(t.joints) for t, *_ in held])
        # (m, nheld) of recordings in motion, and (nrec, nheld) of the others
        torque = np.concatenate([one[1] + np.zeros((len(residual), 1)) for one in held], axis=1)
        at_rest = friction[:, joints] * rests
        columns = self._columns(k, held, len(residual))
        for record, moving in enumerate(group.beginning.moving):
            unit = torque if moving else np.broadcast_to(at_rest[record], torque.shape)
            if not unit.any():
                continue
            here = np.flatnonzero((recording == record) & (place >= 0))
            own = columns[:, :, here] * (unit / self.noise_rad)[..., None]
            left = residual[:, place[here]]
            normal = own @ own.swapaxes(1, 2) + np.eye(len(joints))
            weights = np.linalg.solve(normal, own @ left[..., None])
            residual[:, place[here]] = left - (own.swapaxes(1, 2) @ weights)[..., 0]

    def _columns(
        self, k: int, held: Sequence[tuple[Term, np.ndarray, np.ndarray]], m: int
    ) -> np.ndarray:
        """Positions (m, nheld, nsample of the section) that answer to 1 N·m held, rad."""
        section, way = self.sections[k], self.way[k]
        joints = [joint for term, *_ in held for joint in term.joints]
        reach = np.concatenate([one[2] + np.zeros((m, 1)) for one in held], axis=1)
        # of points that differ in other numbers the fading is the same
        keys = [(joint, far) for row in reach for joint, far in zip(joints, row, strict=True)]
        unique = list(dict.fromkeys(keys))
        fading = np.stack([np.exp(-way[:, :, joint] / far) for joint, far in unique], axis=-1)
        answer = respond(section, fading, np.array([joint for joint, _ in unique]))
        at = np.array([unique.index(key) for key in keys]).reshape(m, -1)
        return answer.T[at]
