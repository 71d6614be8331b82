"""Recordings predicted by a plant with effects: many variants of it in one batch."""

import os
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial

import mujoco
import numpy as np

from t2l.effects.blame import blaming
from t2l.effects.term import Layout, Term
from t2l.errors import T2LError
from t2l.identify import batches
from t2l.identify.initial_state import half_begin_in_motion
from t2l.identify.samples import Samples
from t2l.identify.schedules import Group, groups
from t2l.identify.simulation import (
    acting_every,
    at_every_tick,
    holding,
    simulate,
    starts,
    swinging,
)
from t2l.identify.soft_hold import Gains, hold_gains
from t2l.recordings.recording import Recording
from t2l.robots import plant
from t2l.sim.dry_friction import make_room
from t2l.sim.loop import PHASE
from t2l.sim.servo import EXTENDED, finer


class DivergenceError(T2LError):
    """A simulation of the model runs away."""


@dataclass(frozen=True)
class Request:
    """Variants of the plant to simulate: a layout of terms and (m, n) vectors u."""

    layout: Layout
    u: np.ndarray


class Predictor:
    """Predicts every measured sample of `recordings` for any number of variants at once.

    Attributes:
        joints: driven joints, the same in all recordings.
        samples: what was measured.
        substeps: physics steps a control tick are multiplied by this.
        coarseness: periods of the real control loop from tick to tick, see `t2l.sim.servo`; of a
            plant with more joints than are driven, as between motor and link, two at most.
        in_motion: whether all recordings may begin so, as half do; else those may that clearly do.
        in_balance: whether recordings begin as balance and their first slope say; else what nobody
            sees of their beginning is estimated, see `t2l.identify.hidden_state`.
        holding: N·m/rad and N·m·s/rad (nrec, njoint) of the soft hold to what was measured; None if
            all recordings follow commanded positions.
    """

    def __init__(
        self,
        robot: str,
        recordings: Sequence[Recording],
        substeps: int = 1,
        threads: int | None = None,
        coarseness: int = 1,
        in_motion: bool | None = None,
        in_balance: bool = False,
    ):
        self.robot, self.recordings = robot, tuple(recordings)
        self.joints = self.recordings[0].joints
        self.substeps, self.coarseness = substeps, coarseness
        if in_motion is None:
            in_motion = half_begin_in_motion(self.recordings)
        self.in_motion, self.in_balance = in_motion, in_balance
        self.threads = threads or len(os.sched_getaffinity(0))
        self.samples = Samples.measured(self.recordings)
        self._models: dict[tuple, mujoco.MjModel] = {}
        self.holding = self._holding()
        self._groups = {
            ticks: groups(self.recordings, self.samples, ticks, in_motion, self.holding, in_balance)
            for ticks in {coarseness, min(coarseness, EXTENDED)}
        }

    def _holding(self) -> Gains | None:
        drifting = any(recording.drifts for recording in self.recordings)
        return hold_gains(self.model(), self.recordings) if drifting else None

    def of(self, recordings: Sequence[Recording], coarseness: int | None = None) -> "Predictor":
        """A predictor of other recordings, or of ticks as coarse as said, otherwise the same."""
        coarseness = coarseness or self.coarseness
        return Predictor(
            self.robot, recordings, self.substeps, self.threads, coarseness, self.in_motion,
            self.in_balance,
        )  # fmt: skip

    def model(self, terms: Sequence[Term] = ()) -> mujoco.MjModel:
        """The plant compiled with what `terms` add to its structure."""
        extending = [term for term in terms if term.effect.extends]
        key = _structure(extending)
        if key not in self._models:
            self._models[key] = with_effects(self.robot, self.joints, extending)
        return self._models[key]

    def predict(
        self,
        requests: Sequence[Request],
        velocity: bool = False,
        progress: Callable[[float], None] = lambda part: None,
    ) -> list[np.ndarray] | tuple[list[np.ndarray], list[np.ndarray]]:
        """Position at every sample, (m, nsample) for each request; NaN where it diverged.

        With `velocity`, also the velocity, likewise. `progress` is told now and then which part of
        the work is done.
        """
        q = [np.full((len(request.u), len(self.samples)), np.nan) for request in requests]
        dq = [np.full_like(values, np.nan) for values in q] if velocity else []
        batches.run(self._jobs(requests, velocity, progress), (q, dq), self.threads)
        return (q, dq) if velocity else q

    def at_ticks(
        self, layout: Layout, u: np.ndarray
    ) -> Iterator[tuple[Group, np.ndarray, np.ndarray]]:
        """Each group of recordings with its position and velocity at every tick.

        (ntick, nrec, njoint) rad and rad/s, of one variant u (n,). The phases with which it begins
        stand in the schedule of the group.
        """
        model = self.model(layout.terms)
        variants = [(layout, u[None])]
        for group in self._groups[self._coarseness(model)]:
            loop = model, self.joints, group.schedule, self.substeps
            hidden = starts(*loop, variants, self.threads, group.beginning)
            moved = at_every_tick(*loop, layout, u, self.threads, hidden)
            if hidden is not None and swinging(layout.terms):
                schedule = replace(group.schedule, phase=hidden[0, ..., PHASE])
                group = replace(group, schedule=schedule)
            yield group, *moved

    def _jobs(
        self,
        requests: Sequence[Request],
        velocity: bool,
        progress: Callable[[float], None],
    ) -> list[batches.Job]:
        """Batches to simulate, shared out among the threads."""
        together = batches.Progress(progress)
        parts = [
            (model, pieces, group, self._steps(model, group))
            for model, pieces in self._by_structure(requests)
            for group in self._groups[self._coarseness(model)]
        ]
        work = sum(steps * len(pieces) for _, pieces, _, steps in parts)
        jobs = []
        for model, pieces, group, steps in parts:
            share = int(np.ceil(work / self.threads / steps))
            nrec, ticks = len(group.recordings), group.schedule.sample_ticks
            dofs, numbers = nrec * len(self.joints), len(ticks) * len(self.joints) * 2
            for chunk in batches.chunks(pieces, dofs, numbers, nrec, share):
                variants = [
                    (requests[i].layout, requests[i].u[rows])
                    for i, rows in batches.by_request(chunk)
                ]
                call = partial(
                    simulate, model, self.joints, group.schedule, self.substeps,
                    variants, group.wanted, velocity, beginning=group.beginning,
                    progress=together.of(len(chunk) * steps),
                )  # fmt: skip
                jobs.append(
                    batches.Job(
                        call, chunk, group.held, len(chunk) * nrec, len(chunk) * dofs,
                        len(chunk) * steps, max(1, int(ticks[-1])),
                    )
                )  # fmt: skip
        return jobs

    def _coarseness(self, model: mujoco.MjModel) -> int:
        extended = finer(model, self.joints) > 1
        return min(self.coarseness, EXTENDED) if extended else self.coarseness

    def _steps(self, model: mujoco.MjModel, group: Group) -> int:
        """Steps of single joints that one variant takes."""
        ticks = int(group.schedule.sample_ticks[-1])
        return ticks * len(group.recordings) * model.nv * self.substeps * finer(model, self.joints)

    def _by_structure(self, requests: Sequence[Request]) -> list[tuple]:
        """Models, each with the (request, row) pieces that it simulates.

        What remembers different things begins differently, so that it is simulated apart; and so is
        what acts more often.
        """
        members: dict[tuple, list[int]] = {}
        for i, request in enumerate(requests):
            terms = request.layout.terms
            extending = [term for term in terms if term.effect.extends]
            key = _structure(extending), holding(terms), swinging(terms), acting_every(terms)
            members.setdefault(key, []).append(i)
        return [
            (
                self.model(requests[alike[0]].layout.terms),
                [(i, row) for i in alike for row in range(len(requests[i].u))],
            )
            for alike in members.values()
        ]


def with_effects(
    robot: str, joints: Sequence[str], extending: Sequence[Term] = ()
) -> mujoco.MjModel:
    """The plant compiled with what terms add to its structure, ready to be simulated."""
    spec = plant.load(robot, joints)
    make_room(spec, joints)
    names = [term.effect.name for term in extending]
    for term in extending:
        with blaming([term.effect], "to extend the model"):
            term.effect.extend(spec, tuple(joints[j] for j in term.joints))
    model = plant.compiled(spec, f"{robot}{f' with {", ".join(names)}' if names else ''}")
    # friction that holds at rest, or motor and link on one axis: conjugate gradients take
    # many iterations
    model.opt.solver = mujoco.mjtSolver.mjSOL_NEWTON
    return model


def check_finite(q: np.ndarray, predictor: Predictor, request: Request) -> None:
    """Find a recording whose prediction q (nsample,) is not finite.

    Args:
        request: what was simulated, one variant.

    Raises:
        DivergenceError: naming it, and the effects of the model without which it does not run away,
            or else its gains and its rate.
    """
    bad = np.unique(predictor.samples.recording[~np.isfinite(q)])
    if not len(bad):
        return
    first = predictor.recordings[bad[0]]
    others = f" (and of {len(bad) - 1} more)" if len(bad) > 1 else ""
    said = f"the simulation of {first.path or first.name}{others} diverges"
    guilty = _without_which(predictor.of([first]), request)
    if guilty:
        raise DivergenceError(
            f"{said} with {', '.join(guilty)} of the model, and does not without. Check these "
            "values in the model file: the recording is not at fault."
        )
    raise DivergenceError(
        f"{said}: with Kp up to {first.kp.max():g} and Kd up to {first.kd.max():g} at "
        f"{first.control_rate_hz:g} Hz the model runs away. Check these numbers in the recording's "
        "YAML, the inertias of the robot's MJCF and the effects of the model."
    )


def _without_which(predictor: Predictor, request: Request) -> list[str]:
    """Effects without one of which the simulation is finite; all, if it is so only without all."""
    terms, values = request.layout.terms, request.layout.decode(request.u[:1])

    def finite(rest: Sequence[Term]) -> bool:
        layout = Layout(list(rest))
        own = {
            name: {key: value[0] for key, value in values[name].items()}
            for name in (term.effect.name for term in rest)
        }
        u = layout.encode(own)
        return bool(np.isfinite(predictor.predict([Request(layout, u[None])])[0][0]).all())

    if not terms or not finite(()):
        return []
    names = [term.effect.name for term in terms]
    alone = [
        name
        for i, name in enumerate(names)
        if len(terms) == 1 or finite([*terms[:i], *terms[i + 1 :]])
    ]
    return alone or names


def _structure(terms: Sequence[Term]) -> tuple:
    return tuple(sorted((term.effect.name, term.joints) for term in terms))
