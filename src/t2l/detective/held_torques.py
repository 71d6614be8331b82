"""What a recording begins with that no encoder sees: a torque held by what remembers.

Bristles, or an integral, of a machine in motion hold a torque at the start that nobody knows. It
fades as the joint moves, or stays. To first order it moves positions by a column of its own, which
is free in every fit: it is taken off the residual of each recording (variable projection: Golub
and Pereyra, 1973), as a simulation is begun anew for each variant (`t2l.identify.hidden_state`).
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from t2l.detective.linear_loop import Section, respond
from t2l.effects.blame import blaming
from t2l.effects.term import Layout
from t2l.identify.prediction import Predictor
from t2l.identify.simulation import install
from t2l.sim.driven_loop import DrivenLoop

AT_ONCE = 1e-12  # numerics: rad of motion, after which nothing is left of what has no reach

# of what is held: section, joint, and rad of motion that leave little of it
Key = tuple[int, int, float]


@dataclass(frozen=True)
class _Held:
    """What points (m, n) of a layout may hold at the start, at k places.

    Attributes:
        torque, reach: (m, k) N·m, and rad of motion that leave little of it.
        joints: (k,) of the places; at `rests` (k,) something may be held from rest too.
    """

    layout: Layout
    points: np.ndarray
    torque: np.ndarray
    reach: np.ndarray
    joints: np.ndarray
    rests: np.ndarray

    @classmethod
    def of(cls, layout: Layout, points: np.ndarray) -> "_Held | None":
        terms = [term for term in layout.terms if term.effect.holds_torque]
        if not terms:
            return None
        values, m = layout.decode(points), len(points)
        each = [(term, *term.effect.held(values[term.effect.name])) for term in terms]
        return cls(
            layout,
            points,
            np.concatenate([np.broadcast_to(t, (m, len(term.joints))) for term, t, _ in each], 1),
            np.concatenate([np.broadcast_to(r, (m, len(term.joints))) for term, _, r in each], 1),
            np.array([joint for term in terms for joint in term.joints]),
            np.array([term.effect.holds_at_rest for term in terms for _ in term.joints]),
        )

    def keys(self, section: int) -> list[list[Key]]:
        """(m, k) of what moves positions alike."""
        pairs = (zip(self.joints.tolist(), row, strict=True) for row in self.reach.tolist())
        return [[(section, joint, far) for joint, far in row] for row in pairs]


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
        # what lasts is the same for all variants
        self._lasting: dict[Key, np.ndarray] = {}

    def freed(
        self, asked: Sequence[tuple[Layout, np.ndarray]], residuals: Sequence[np.ndarray]
    ) -> list[np.ndarray]:
        """Residuals (m, nsample) of points (m, n) of layouts, less what starts may explain."""
        held = [_Held.of(layout, points) for layout, points in asked]
        free = [r if one is None else r.copy() for one, r in zip(held, residuals, strict=True)]
        some = [(one, r) for one, r in zip(held, free, strict=True) if one is not None]
        for section in range(len(self.sections) if some else 0):
            known = self._columns(section, [one for one, _ in some])
            for one, residual in some:
                self._free(section, one, known, residual)
        return free

    def _columns(self, section: int, held: Sequence[_Held]) -> dict[Key, np.ndarray]:
        """Positions (nsample of the section,) that answer to 1 N·m held, rad."""
        keys = dict.fromkeys(key for one in held for row in one.keys(section) for key in row)
        known = {key: self._lasting[key] for key in keys if key in self._lasting}
        new = [key for key in keys if key not in known]
        if new:
            way, joints = self.way[section], np.array([joint for _, joint, _ in new])
            lasting = (np.exp(-way[:, :, joint] / max(far, AT_ONCE)) for _, joint, far in new)
            fading = np.stack([*lasting], axis=-1)
            answers = respond(self.sections[section], fading, joints)
            # a loop that runs away along the motion tells nothing of the start
            answers = np.where(np.isfinite(answers), answers, 0.0)
            known |= zip(new, answers.T, strict=True)
            self._lasting |= {key: known[key] for key in new if np.isinf(key[2])}
        return known

    def _friction(self, section: Section, held: _Held) -> np.ndarray:
        """N·m (nrec, njoint) that friction holds at rest, at the first of some points."""
        model, schedule = self.predictor.model(held.layout.terms), section.motion.group.schedule
        loop = DrivenLoop(model, self.predictor.joints, schedule, 1)
        loop.path = section.path
        with blaming([term.effect for term in held.layout.terms], "to lead it"):
            install(loop, [(held.layout, held.points[:1])])
            return loop.friction_at_rest(section.path.load[0])

    def _free(
        self, k: int, held: _Held, known: dict[Key, np.ndarray], residual: np.ndarray
    ) -> None:
        """Change the residual (m, nsample) in place."""
        section = self.sections[k]
        group, moving = section.motion.group, section.motion.group.schedule.may_move
        place, recording = self.place[group.held], group.wanted[0]
        at_rest = np.zeros((len(moving), len(held.joints)))
        if held.rests.any() and not moving.all():
            at_rest = self._friction(section, held)[:, held.joints] * held.rests
        keys = held.keys(k)
        for record, moves in enumerate(moving):
            unit = held.torque if moves else np.broadcast_to(at_rest[record], held.torque.shape)
            if not unit.any():
                continue
            here = np.flatnonzero((recording == record) & (place >= 0))
            own = np.array([[known[key][here] for key in row] for row in keys])
            own *= (unit / self.noise_rad)[..., None]
            left = residual[:, place[here]]
            normal = own @ own.swapaxes(1, 2) + np.eye(len(held.joints))
            weights = np.linalg.solve(normal, own @ left[..., None])
            residual[:, place[here]] = left - (own.swapaxes(1, 2) @ weights)[..., 0]
