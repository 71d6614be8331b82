"""What each parameter of each effect changes in measured positions, by finite differences.

Around the model, each effect is present at a plausible size, one at a time: of its first guesses
the one whose response is nearest to `TYPICAL` times the noise. Where an effect has no derivative,
its response is the difference that it makes as a whole. Columns are in units of the noise for a
change of a parameter by its plausible size: of length one, it is as uncertain as it is large.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from t2l.effects.effect import Effect
from t2l.effects.term import Layout, Slot, Term
from t2l.identify.first_guesses import first_guesses
from t2l.identify.model import Model
from t2l.identify.prediction import Predictor, Request
from t2l.identify.samples import Samples
from t2l.identify.scales import sized
from t2l.recordings.recording import Recording

NOISE_RAD = 1e-4  # guess: of an encoder, where no log tells
STEP = 0.1  # numerics: of a plausible size: more than roughness, less than what bends a response
# bound: times the noise: the largest effect that is to be found, and the middle, in logarithms,
# from 3 on
LARGEST, TYPICAL = 300.0, 30.0
LOOP_HZ = 250.0  # numerics: ticks as fast as this are fine enough for a derivative
NUMBERS = 2e7  # numerics: of the matrix of one chunk of recordings: 160 MB


@dataclass(frozen=True)
class Presence:
    """An effect at its plausible size, beside those that the model has.

    Attributes:
        layout, u: of all terms; `size` of each element of u.
        own: (k,) which elements of u are its parameters.
    """

    effect: Effect
    layout: Layout
    u: np.ndarray
    size: np.ndarray
    own: np.ndarray

    @property
    def free(self) -> np.ndarray:
        """(k,) those of `own` that have a derivative and are no more fixed than their bounds."""
        layout = self.layout
        loose = ~layout.rough & (layout.lower < layout.upper)
        return self.own[loose[self.own]]

    def points(self) -> np.ndarray:
        """u (1 + m, n): the plausible one, and those that the differences are of."""
        moved = [self.u.copy() for _ in self._together()]
        for point, members in zip(moved, self._together(), strict=True):
            point[members] += self._steps()[members]
        return np.array([self.u, *moved])

    def columns(self, q: np.ndarray, joint: np.ndarray) -> np.ndarray:
        """(nsample, k) rad that a change of each of `free` by its size makes, in proportion.

        Args:
            q: (1 + m, nsample) rad, predicted at `points`; `joint` (nsample,) of the samples.
        """
        part = self._steps() / self.size
        found = np.zeros((q.shape[1], len(self.u)))
        for difference, members in zip(q[1:] - q[0], self._together(), strict=True):
            for i in members:
                alone = len(members) > 1 or self._alone(i)
                own = not alone or joint == self.layout.slots[i].joint
                found[:, i] = np.where(own, difference / part[i], 0.0)
        return found[:, self.free]

    def _steps(self) -> np.ndarray:
        step = STEP * self.size
        step = np.where(self.u + step > self.layout.upper, -step, step)
        return np.where(self.u + step < self.layout.lower, self.layout.upper - self.u, step)

    def _together(self) -> list[np.ndarray]:
        """Index sets of elements that are moved at once, as each moves its own joint alone."""
        groups: dict[tuple, list[int]] = {}
        for i in self.free:
            key = (self.layout.slots[i].parameter.name,) if self._alone(i) else (i,)
            groups.setdefault(key, []).append(i)
        return [np.array(group) for group in groups.values()]

    def _alone(self, i: int) -> bool:
        return self.layout.slots[i].joint is not None and not self.effect.coupled


@dataclass(frozen=True)
class Column:
    """What a column of a matrix of sensitivities is of.

    Attributes:
        slot: None for an effect as a whole, which has no derivatives.
        joint: index; None for a parameter of the robot.
        value: plausible, of the parameter itself; `size` its change that counts as large, of u.
    """

    effect: Effect
    slot: Slot | None
    joint: int | None
    value: float
    size: float


@dataclass(frozen=True)
class Responses:
    """How some recordings would answer, in units of the noise.

    Attributes:
        recording, joint: (nsample,) indices of each sample, the former among all recordings.
        columns: (nsample, ncolumn); `wholes` (nsample, neffect) of each effect at its size.
    """

    recording: np.ndarray
    joint: np.ndarray
    columns: np.ndarray
    wholes: np.ndarray


class Sensitivity:
    """Sensitivities of a model to some effects.

    Args:
        reference: recordings, as the model predicts them, by which plausible sizes are chosen.
        noise_rad: standard deviation of a measured position.
        substeps: as of a `Predictor`.

    Attributes:
        presences: the effects at their plausible sizes; those with which every simulation runs away
            are left out.
        columns: what the columns are of.
    """

    def __init__(
        self,
        model: Model,
        effects: Sequence[Effect],
        reference: Sequence[Recording],
        noise_rad: float = NOISE_RAD,
        substeps: int = 1,
    ):
        self.model, self.noise_rad, self.substeps = model, noise_rad, substeps
        self.joints = reference[0].joints
        fitting = predicted(self.predictor(reference), *model.vector(self.joints))
        self.model = sized(model, fitting)
        self._adopted, known = self.model.vector(self.joints), self.model.known_effects(self.joints)
        effects = [known.get(effect.name, effect) for effect in effects]
        self.presences = list(self._at_plausible_sizes(effects, fitting))
        self.columns = [c for presence in self.presences for c in _columns(presence)]

    def responses(self, recordings: Sequence[Recording]) -> Iterator[Responses]:
        """Of all recordings, some of them at a time."""
        numbers = [r.q.size * max(1, len(self.columns)) for r in recordings]
        first = 0
        while first < len(recordings):
            held = np.cumsum(numbers[first:]) <= NUMBERS
            last = first + max(1, int(held.sum()))
            yield self._responses(recordings[first:last], first)
            first = last

    def information(self, recordings: Sequence[Recording]) -> np.ndarray:
        """Fisher's information of each recording, (nrecording, ncolumn, ncolumn).

        Under independent noise of equal size it is Jᵀ J / σ² (Kay, Fundamentals of statistical
        signal processing, 1993, section 3.9).
        """
        found = np.zeros((len(recordings), len(self.columns), len(self.columns)))
        for part in self.responses(recordings):
            for number in np.unique(part.recording):
                rows = part.columns[part.recording == number]
                found[number] = rows.T @ rows
        return found

    def predictor(self, recordings: Sequence[Recording]) -> Predictor:
        """What simulates recordings on ticks that are fine enough for derivatives."""
        rate = max(r.control_rate_hz for r in recordings)
        return Predictor(
            self.model.robot, recordings, self.substeps,
            coarseness=max(1, int(rate / LOOP_HZ + 1e-6)),
        )  # fmt: skip

    def _responses(self, recordings: Sequence[Recording], first: int) -> Responses:
        predictor = self.predictor(recordings)
        samples = predictor.samples
        layout, u = self._adopted
        asked = [Request(p.layout, p.points()) for p in self.presences]
        (plain,), *moved = predictor.predict([Request(layout, u[None]), *asked])
        range_rad = np.maximum(_ranges(samples, plain), LARGEST * self.noise_rad)
        wholes = np.zeros((len(samples), len(moved)))
        blocks = [np.zeros((len(samples), 0))]
        for i, (presence, q) in enumerate(zip(self.presences, moved, strict=True)):
            whole = np.nan_to_num(q[0] - plain, nan=np.inf)
            square = np.bincount(samples.recording, whole**2, len(recordings))
            count = np.bincount(samples.recording, minlength=len(recordings))
            tame = (square <= count * range_rad**2)[samples.recording]
            wholes[tame, i] = whole[tame] / self.noise_rad
            if len(presence.free):
                columns = np.nan_to_num(presence.columns(q, samples.joint)) / self.noise_rad
                blocks.append(np.where(tame[:, None], columns, 0.0))
            else:
                blocks.append(_by_joint(presence, wholes[:, i], samples.joint))
        return Responses(
            samples.recording + first, samples.joint, np.concatenate(blocks, axis=1), wholes
        )

    def _at_plausible_sizes(
        self, effects: Sequence[Effect], predictor: Predictor
    ) -> Iterator[Presence]:
        layout, u = self._adopted
        values = {
            name: {k: v[0] for k, v in p.items()} for name, p in layout.decode(u[None]).items()
        }
        every = tuple(range(len(self.joints)))
        wholes, trials = [], []
        for effect in effects:
            others = [term for term in layout.terms if term.effect.name != effect.name]
            wholes.append(Layout([*others, Term(effect, every)]))
            guesses = first_guesses(effect, self.model.sizes, len(every))
            trials.append(
                np.array([wholes[-1].encode({**values, effect.name: g}) for g in guesses])
            )
        found = predictor.predict([Request(w, t) for w, t in zip(wholes, trials, strict=True)])
        for effect, whole, tried, q in zip(effects, wholes, trials, found, strict=True):
            # one that ran away is NaN, and no guess
            rms = np.sqrt(np.mean((q - predictor.samples.q) ** 2, axis=1))
            if not np.isfinite(rms).any():
                continue
            far = np.abs(np.log(np.maximum(rms, 1e-12) / (TYPICAL * self.noise_rad)))
            chosen = int(np.nanargmin(far))
            own = np.array(
                [i for i, s in enumerate(whole.slots) if s.term.effect.name == effect.name]
            )
            yield Presence(effect, whole, tried[chosen], _sizes(whole, tried, chosen), own)


def _ranges(samples: Samples, q: np.ndarray) -> np.ndarray:
    """The largest range of a joint in each recording, rad, of what is predicted.

    A response larger than the motion itself is a loop that runs away: no measure of a parameter.
    """
    signals = samples.by_row(q)
    return np.array([np.max(np.nanmax(s, axis=0) - np.nanmin(s, axis=0)) for s in signals])


def predicted(predictor: Predictor, layout: Layout, u: np.ndarray) -> Predictor:
    """A predictor of the same recordings whose measured positions are what a model predicts."""
    (q,) = predictor.predict([Request(layout, u[None])])
    measured = predictor.samples.by_row(np.where(np.isfinite(q[0]), q[0], predictor.samples.q))
    return predictor.of(
        [replace(r, q=m) for r, m in zip(predictor.recordings, measured, strict=True)]
    )


def _sizes(layout: Layout, tried: np.ndarray, chosen: int) -> np.ndarray:
    """What counts as a large change of each element of u.

    The distance of the chosen guess from absence, or of the guess nearest to it that has any; where
    absence is a limit or nowhere, a factor of e or one unit; never less than the size that the
    parameter itself states.

    Args:
        tried: (m, n) guesses.
    """
    away = np.abs(tried - layout.neutral)
    nearest = np.where(away > 0, away, np.inf).min(axis=0)
    size = np.where(away[chosen] > 0, away[chosen], nearest)
    stated = np.array([slot.size for slot in layout.slots], float)
    size = np.maximum(np.where(np.isfinite(size), size, 0.0), stated)
    return np.where(size > 0, size, [slot.scale for slot in layout.slots])


def _columns(presence: Presence) -> list[Column]:
    layout, effect = presence.layout, presence.effect
    if not len(presence.free):
        joints = {layout.slots[i].joint for i in presence.own}
        return [
            Column(effect, None, joint, 1.0, 1.0) for joint in sorted(joints, key=lambda j: j or 0)
        ]
    theta = layout.theta(presence.u)
    return [
        Column(
            effect, layout.slots[i], layout.slots[i].joint, float(theta[i]), float(presence.size[i])
        )
        for i in presence.free
    ]  # fmt: skip


def _by_joint(presence: Presence, whole: np.ndarray, joint: np.ndarray) -> np.ndarray:
    """(nsample, n) of an effect as a whole, a column for each joint that has it by itself."""
    return np.stack(
        [
            whole if column.joint is None else np.where(joint == column.joint, whole, 0.0)
            for column in _columns(presence)
        ],
        axis=1,
    )
