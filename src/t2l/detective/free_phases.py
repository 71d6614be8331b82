"""The phase of what swings freely, which nobody knows where a recording begins.

It is free in every fit along the motion: for each variant the residual of each recording is that
with the best phase of each joint, which the first half of the recording tells (variable projection:
Golub and Pereyra, 1973), as a simulation is begun anew for each (`t2l.identify.hidden_state`). The
positions that answer to a sine and a cosine of one frequency are those to any phase.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from t2l.detective.linear_loop import Section, respond
from t2l.effects.term import Layout, Term
from t2l.identify.levels import HALF
from t2l.identify.prediction import Predictor

ANGLES = 2 * np.pi / 90 * np.arange(90)  # numerics: phases that are compared
SWEEPS = 3  # numerics: over joints, each with the best phase beside the others
NEWTON = 2  # numerics: steps from the best of the phases that were compared
TINY = 1e-300  # numerics: in place of a curvature that is none

# of a swing: section, joint and Hz
Key = tuple[int, int, float]


@dataclass(frozen=True)
class _Swing:
    """What points (m, n) of a layout have that swings, at k places.

    Attributes:
        amplitude, frequency: (m, k) N·m and Hz.
        joints: (k,) of the places.
    """

    amplitude: np.ndarray
    frequency: np.ndarray
    joints: np.ndarray

    @classmethod
    def of(cls, layout: Layout, points: np.ndarray) -> "_Swing | None":
        terms = [term for term in layout.terms if term.effect.swings]
        if not terms:
            return None
        values = layout.decode(points)
        each = [term.effect.oscillation(values[term.effect.name]) for term in terms]
        amplitude, frequency = (np.concatenate(parts, axis=1) for parts in zip(*each, strict=True))
        return cls(amplitude, frequency, np.array([j for term in terms for j in term.joints]))

    def keys(self, section: int) -> list[list[Key]]:
        """(m, k) of what moves positions alike."""
        pairs = (zip(self.joints.tolist(), row, strict=True) for row in self.frequency.tolist())
        return [[(section, joint, hz) for joint, hz in row] for row in pairs]


class FreePhases:
    """Gives what swings in a model its best phase in each recording.

    Args:
        predictor: of the samples.
        sections: the loop along the motion; what swings has the phase of their schedule so far.
        fitted: (k,) indices of the samples that are fitted, of which residuals are.
    """

    def __init__(self, predictor: Predictor, sections: Sequence[Section], fitted: np.ndarray):
        self.predictor, self.sections = predictor, sections
        self.place = np.full(len(predictor.samples), -1)
        self.place[fitted] = np.arange(len(fitted))
        length = np.array([recording.duration_s for recording in predictor.recordings])
        samples = predictor.samples
        self.early = samples.time <= HALF * length[samples.recording]

    def turned(
        self,
        asked: Sequence[tuple[Layout, np.ndarray]],
        residuals: Sequence[np.ndarray],
        stiffer: Sequence[Sequence[np.ndarray]],
    ) -> list[np.ndarray]:
        """Residuals (m, nfitted) of points (m, n) of layouts with the best phases.

        Args:
            stiffer: by section, for each of `asked` (m, njoint), by what positions are divided.
        """
        swings = [_Swing.of(layout, points) for layout, points in asked]
        turned = [r if one is None else r.copy() for one, r in zip(swings, residuals, strict=True)]
        some = [(i, one) for i, one in enumerate(swings) if one is not None]
        for section in range(len(self.sections) if some else 0):
            known = self._columns(section, [one for _, one in some])
            for i, one in some:
                self._turn(section, one, known, turned[i], stiffer[section][i])
        return turned

    def phases(self, term: Term, points: np.ndarray, residual: np.ndarray) -> np.ndarray:
        """(m, nrecording, njoint) rad that explain most of a residual at any amplitude, or zero.

        Args:
            points: (m, n) of the term.
            residual: (nsample,) measured minus predicted without it, rad.
        """
        predictor = self.predictor
        found = np.zeros((len(points), len(predictor.recordings), len(predictor.joints)))
        one = _Swing.of(Layout([term]), points)
        for k, section in enumerate(self.sections):
            known = self._columns(k, [one])
            for record, here, _ in self._recordings(k):
                left, phase = residual[section.motion.group.held[here]], {}
                for key, waves in known.items():
                    sine, cosine = np.linalg.lstsq(waves[:, here].T, left, rcond=None)[0]
                    phase[key] = np.arctan2(cosine, sine)
                for m, keys in enumerate(one.keys(k)):
                    found[m, record, one.joints] = [phase[key] for key in keys]
        return found

    def _columns(self, section: int, swings: Sequence[_Swing]) -> dict[Key, np.ndarray]:
        """Positions (2, nsample of the section) that answer to sine and cosine of 1 N·m, rad."""
        keys = [*dict.fromkeys(key for one in swings for row in one.keys(section) for key in row)]
        own = self.sections[section]
        schedule, shape = own.motion.group.schedule, own.path.q.shape
        clock = (np.arange(shape[0]) + 0.5) * schedule.period_s
        begins = np.zeros(shape[1:]) if schedule.phase is None else schedule.phase
        waves = []
        for _, joint, hz in keys:
            angle = 2 * np.pi * hz * clock[:, None] + begins[:, joint]
            waves += [np.sin(angle), np.cos(angle)]
        joints = np.repeat([joint for _, joint, _ in keys], 2)
        answers = respond(own, np.stack(waves, axis=-1), joints)
        # a loop that runs away along the motion tells nothing of it
        answers = np.where(np.isfinite(answers), answers, 0.0).T
        return dict(zip(keys, answers.reshape(len(keys), 2, -1), strict=True))

    def _recordings(self, section: int):
        """Each recording's index, its fitted samples of the section's, and which tell its phase."""
        group = self.sections[section].motion.group
        for i, record in enumerate(group.recordings):
            here = np.flatnonzero((group.wanted[0] == i) & (self.place[group.held] >= 0))
            if len(here):
                yield record, here, self.early[group.held[here]]

    def _turn(
        self,
        k: int,
        swing: _Swing,
        known: dict[Key, np.ndarray],
        residual: np.ndarray,
        stiffer: np.ndarray,
    ) -> None:
        """Change the residual (m, nfitted) in place."""
        group, keys = self.sections[k].motion.group, swing.keys(k)
        for _, here, early in self._recordings(k):
            at = self.place[group.held[here]]
            # (m, k, 2, n): sine and cosine of each place
            waves = np.array([[known[key][:, here] for key in row] for row in keys])
            waves *= swing.amplitude[..., None, None]
            waves /= stiffer[:, None, None, group.wanted[3][here]]
            without = residual[:, at] - waves[:, :, 0].sum(axis=1)
            m, places, _, n = waves.shape
            flat = waves.reshape(m, 2 * places, n)
            told = flat[..., early]
            gram = told @ told.swapaxes(1, 2)
            along = (told @ without[:, early, None])[..., 0]
            turn = best_turns(gram, along)
            residual[:, at] = without + (flat.swapaxes(1, 2) @ turn[..., None])[..., 0]


def best_turns(gram: np.ndarray, along: np.ndarray) -> np.ndarray:
    """Weights w (m, 2k), cosine and sine of an angle each, that minimise w·G w + 2 a·w.

    Args:
        gram: (m, 2k, 2k), of m problems with k angles; along: (m, 2k).
    """
    w = np.tile([1.0, 0.0], (len(along), along.shape[1] // 2))
    angles = np.stack([np.cos(ANGLES), np.sin(ANGLES)])
    places = range(along.shape[1] // 2)
    for _ in range(SWEEPS if len(places) > 1 else 1):
        for i in places:
            mine = slice(2 * i, 2 * i + 2)
            own = gram[:, mine, mine]
            rest = along[:, mine] + np.einsum("mij,mj->mi", gram[:, mine], w)
            rest -= np.einsum("mij,mj->mi", own, w[:, mine])
            left = np.einsum("ia,mij,ja->ma", angles, own, angles) + 2 * rest @ angles
            angle = ANGLES[np.argmin(left, axis=1)]
            for _ in range(NEWTON):
                at = np.stack([np.cos(angle), np.sin(angle)], axis=1)
                by = np.stack([-at[:, 1], at[:, 0]], axis=1)
                pull = rest + np.einsum("mij,mj->mi", own, at)
                slope = np.einsum("mi,mi->m", by, pull)
                bend = np.einsum("mi,mij,mj->m", by, own, by) - np.einsum("mi,mi->m", at, pull)
                angle = angle - slope / np.maximum(bend, TINY) * (bend > 0)
            w[:, mine] = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    return w


def with_phase(section: Section, phase: np.ndarray, joints: Sequence[int]) -> Section:
    """A section with other phases (nrecording, njoint) of some joints, rad."""
    group = section.motion.group
    schedule = group.schedule
    whole = np.zeros_like(schedule.kp) if schedule.phase is None else schedule.phase.copy()
    whole[:, joints] = phase[np.ix_(group.recordings, joints)]
    group = replace(group, schedule=replace(schedule, phase=whole))
    return replace(section, motion=replace(section.motion, group=group))
