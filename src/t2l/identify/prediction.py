"""Recordings predicted by a plant with effects: many variants of it in one batch."""

import os
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import cached_property, partial

import mujoco
import numpy as np

from t2l.effects.blame import blaming
from t2l.effects.effect import Scales
from t2l.effects.term import Layout, Term
from t2l.errors import T2LError
from t2l.identify.initial_state import start_state
from t2l.identify.simulation import simulate
from t2l.recordings.recording import Recording
from t2l.robots import plant
from t2l.sim.servo import Schedule

MAX_SIMULATIONS = 1024  # in one batch; more gain nothing and cost memory
MAX_NUMBERS = 3e7  # recorded by one batch
LEAST_STEPS_PER_THREAD = 20  # of single joints a tick, for which another one pays
LEAST_DOFS_PER_BATCH = 400  # of its simulations together, to be run beside another one
GRAVITY_POSES = 20_000  # beyond, gravity is interpolated between poses


class DivergenceError(T2LError):
    """A simulation of the model runs away."""


@dataclass(frozen=True)
class Samples:
    """Where the recordings were measured, flat: (nsample,) each.

    Attributes:
        recording, joint, row: indices.
        time: s since the recording's start.
        q: rad, measured.
    """

    recording: np.ndarray
    joint: np.ndarray
    row: np.ndarray
    time: np.ndarray
    q: np.ndarray

    def __len__(self) -> int:
        return len(self.q)


@dataclass(frozen=True)
class Request:
    """Variants of the plant to simulate: a layout of terms and (m, n) vectors u."""

    layout: Layout
    u: np.ndarray


@dataclass(frozen=True)
class _Group:
    schedule: Schedule
    recordings: tuple[int, ...]


@dataclass(frozen=True)
class _Job:
    """One batch: `call` simulates `chunk`, pieces (request, row), at the samples `held`.

    Attributes:
        simulations: how many, which have `dofs` driven joints together.
        steps: of single joints that they take in `ticks` ticks.
    """

    call: Callable[..., tuple[np.ndarray, ...]]
    chunk: list[tuple[int, int]]
    held: np.ndarray
    simulations: int
    dofs: int
    steps: int
    ticks: int

    def threads(self, most: int) -> int:
        """As many as pay."""
        paying = self.steps // (self.ticks * LEAST_STEPS_PER_THREAD)
        return max(1, min(most, self.simulations, paying))

    def run(self, outs: Sequence[list[np.ndarray]], threads: int) -> None:
        """Simulate, and put what is found into the arrays (m, nsample) of each request."""
        for found, out in zip(self.call(threads=threads), outs, strict=False):
            at = 0
            for i, rows in _runs(self.chunk):
                out[i][np.ix_(rows, self.held)] = found[at : at + len(rows)]
                at += len(rows)


class Predictor:
    """Predicts every measured sample of `recordings` for any number of variants at once.

    Attributes:
        joints: driven joints, the same in all recordings.
        samples: what was measured.
        substeps: physics steps a control tick are multiplied by this.
        coarseness: periods of the real control loop from tick to tick, see `t2l.sim.servo`.
    """

    def __init__(
        self,
        robot: str,
        recordings: Sequence[Recording],
        substeps: int = 1,
        threads: int | None = None,
        coarseness: int = 1,
    ):
        self.robot, self.recordings = robot, tuple(recordings)
        self.joints = self.recordings[0].joints
        self.substeps, self.coarseness = substeps, coarseness
        self.threads = threads or len(os.sched_getaffinity(0))
        self._models: dict[tuple, mujoco.MjModel] = {}
        self._rows = [~np.isnan(recording.q).all(axis=1) for recording in self.recordings]
        self.samples = self._samples()
        self._groups = [self._group(indices) for indices in self._alike()]
        self._flat = self._flat_index()

    def of(self, recordings: Sequence[Recording], coarseness: int | None = None) -> "Predictor":
        """A predictor of other recordings, or of ticks as coarse as said, otherwise the same."""
        coarseness = coarseness or self.coarseness
        return Predictor(self.robot, recordings, self.substeps, self.threads, coarseness)

    def _samples(self) -> Samples:
        parts = []
        for index, recording in enumerate(self.recordings):
            row, joint = np.nonzero(~np.isnan(recording.q))
            time = recording.time[row] - recording.time[0]
            parts.append((np.full(len(row), index), joint, row, time, recording.q[row, joint]))
        return Samples(*(np.concatenate(column) for column in zip(*parts, strict=True)))

    def _alike(self) -> list[list[int]]:
        groups: dict[tuple, list[int]] = {}
        for index, recording in enumerate(self.recordings):
            # recordings of like length: none waits long for another
            length = round(np.log(max(recording.duration_s, 1e-3)) / np.log(1.5))
            groups.setdefault((recording.control_rate_hz, length), []).append(index)
        return list(groups.values())

    def _group(self, indices: list[int]) -> _Group:
        recordings = [self.recordings[i] for i in indices]
        real_period = 1.0 / recordings[0].control_rate_hz
        period = self.coarseness * real_period
        last = max(int(np.ceil(r.duration_s / period - 1e-6)) for r in recordings)
        ticks, real = np.arange(last + 2), np.arange((last + 2) * self.coarseness)
        commands = np.empty((len(ticks), len(recordings), len(self.joints)))
        wanted = {0}
        for column, recording in enumerate(recordings):
            elapsed = recording.time - recording.time[0]
            row = np.searchsorted(elapsed, real * real_period + 1e-6, side="right") - 1
            held = recording.q_des[row].reshape(len(ticks), self.coarseness, -1)
            commands[:, column] = held.mean(axis=1)
            below, _ = _ticks(elapsed[self._rows[indices[column]]], period)
            wanted.update(below.tolist(), (below + 1).tolist())
        start = [start_state(recording) for recording in recordings]
        schedule = Schedule(
            period_s=period,
            commands=commands,
            kp=np.array([r.kp for r in recordings]),
            kd=np.array([r.kd for r in recordings]),
            start_q=np.array([q for q, _ in start]),
            start_dq=np.array([dq for _, dq in start]),
            gravity_compensation=np.array([r.gravity_compensation for r in recordings]),
            sample_ticks=np.array(sorted(wanted)),
            coarseness=self.coarseness,
        )
        return _Group(schedule, tuple(indices))

    def _flat_index(self) -> list[tuple]:
        """Per group: which samples it holds, and where they lie in its output."""
        index = []
        for group in self._groups:
            column = {recording: i for i, recording in enumerate(group.recordings)}
            held = np.flatnonzero(np.isin(self.samples.recording, group.recordings))
            below, rest = _ticks(self.samples.time[held], group.schedule.period_s)
            tick = np.searchsorted(group.schedule.sample_ticks, below)
            record = np.array([column[r] for r in self.samples.recording[held]])
            index.append((held, record, tick, rest, self.samples.joint[held]))
        return index

    def model(self, terms: Sequence[Term] = ()) -> mujoco.MjModel:
        """The plant compiled with what `terms` add to its structure."""
        extending = [term for term in terms if term.effect.extends]
        key = _structure(extending)
        if key not in self._models:
            spec = plant.load(self.robot, self.joints)
            names = [term.effect.name for term in extending]
            for term in extending:
                with blaming([term.effect], "to extend the model"):
                    term.effect.extend(spec, tuple(self.joints[j] for j in term.joints))
            with_effects = f"{self.robot}{f' with {", ".join(names)}' if names else ''}"
            model = self._models[key] = plant.compiled(spec, with_effects)
            if model.nv > len(self.joints):
                # motor and link on one axis: conjugate gradients take many iterations
                model.opt.solver = mujoco.mjtSolver.mjSOL_NEWTON
        return self._models[key]

    def predict(
        self, requests: Sequence[Request], velocity: bool = False
    ) -> list[np.ndarray] | tuple[list[np.ndarray], list[np.ndarray]]:
        """Position at every sample, (m, nsample) for each request; NaN where it diverged.

        With `velocity`, also the velocity, likewise.
        """
        q = [np.full((len(request.u), len(self.samples)), np.nan) for request in requests]
        dq = [np.full_like(values, np.nan) for values in q] if velocity else []
        jobs = self._jobs(requests, velocity)
        large = [job for job in jobs if job.dofs >= LEAST_DOFS_PER_BATCH]
        small = [job for job in jobs if job.dofs < LEAST_DOFS_PER_BATCH]
        # while one computes torques another steps its physics
        threads = max(1, self.threads // max(1, len(large)))
        with ThreadPoolExecutor(self.threads) as pool:
            done = [pool.submit(job.run, (q, dq), job.threads(threads)) for job in large]
            for future in done:
                future.result()
        for job in small:
            job.run((q, dq), job.threads(self.threads))
        return (q, dq) if velocity else q

    def _jobs(self, requests: Sequence[Request], velocity: bool) -> list[_Job]:
        """Batches to simulate, shared out among the threads, the longest first."""
        parts = [
            (model, pieces, group, flat, self._steps(model, group))
            for model, pieces in self._by_structure(requests)
            for group, flat in zip(self._groups, self._flat, strict=True)
        ]
        work = sum(steps * len(pieces) for _, pieces, _, _, steps in parts)
        jobs = []
        for model, pieces, group, (held, *wanted), steps in parts:
            share = int(np.ceil(work / self.threads / steps))
            for chunk in _chunks(pieces, self._chunk_size(group, len(pieces), share)):
                variants = [(requests[i].layout, requests[i].u[rows]) for i, rows in _runs(chunk)]
                call = partial(
                    simulate, model, self.joints, group.schedule, self._substeps(model), variants,
                    wanted, velocity,
                )  # fmt: skip
                simulations = len(chunk) * len(group.recordings)
                dofs, taken = simulations * len(self.joints), len(chunk) * steps
                ticks = max(1, int(group.schedule.sample_ticks[-1]))
                jobs.append(_Job(call, chunk, held, simulations, dofs, taken, ticks))
        return sorted(jobs, key=lambda job: -job.steps)

    def _chunk_size(self, group: _Group, pieces: int, share: int) -> int:
        """How many variants go into one batch: a thread's share, if that is worth a batch."""
        dofs = len(group.recordings) * len(self.joints)
        numbers = len(group.schedule.sample_ticks) * len(self.joints) * 2
        simulations = min(MAX_SIMULATIONS, MAX_NUMBERS / numbers)
        largest = max(1, int(simulations // len(group.recordings)))
        batches = max(1, min(-(-pieces // share), pieces * dofs // LEAST_DOFS_PER_BATCH))
        return min(largest, -(-pieces // batches))

    def _substeps(self, model: mujoco.MjModel) -> int:
        extended = model.nv > len(self.joints)
        return self.substeps * (max(2, self.coarseness) if extended else 1)

    def _steps(self, model: mujoco.MjModel, group: _Group) -> int:
        """Steps of single joints that one variant takes."""
        ticks = int(group.schedule.sample_ticks[-1])
        return ticks * len(group.recordings) * model.nv * self._substeps(model)

    def _by_structure(self, requests: Sequence[Request]) -> list[tuple]:
        """Models, each with the (request, row) pieces that it simulates."""
        members: dict[tuple, list[int]] = {}
        for i, request in enumerate(requests):
            extending = [term for term in request.layout.terms if term.effect.extends]
            members.setdefault(_structure(extending), []).append(i)
        return [
            (
                self.model(requests[alike[0]].layout.terms),
                [(i, row) for i in alike for row in range(len(requests[i].u))],
            )
            for alike in members.values()
        ]

    @cached_property
    def scales(self) -> Scales:
        """Sizes for first guesses, from the plant as it is under the recordings' commands."""
        samples, kp = self.samples, np.array([r.kp for r in self.recordings])
        kd = np.array([r.kd for r in self.recordings])
        empty = Request(Layout(()), np.zeros((1, 0)))
        _, dq = self.predict([empty], velocity=True)
        velocity = np.nan_to_num(dq[0][0])
        command = self.at_samples([r.q_des for r in self.recordings])
        torque = kp[samples.recording, samples.joint] * (command - samples.q)
        torque -= kd[samples.recording, samples.joint] * velocity
        compensated = np.array([r.gravity_compensation for r in self.recordings])
        torque += np.where(compensated[samples.recording], self.gravity_at_samples(), 0.0)

        def per_joint(function, values):
            return np.array([function(values[samples.joint == j]) for j in range(len(self.joints))])

        step = np.array(
            [
                [np.abs(np.diff(r.q_des[:, j])).max(initial=0) * r.kp[j] for r in self.recordings]
                for j in range(len(self.joints))
            ]
        ).max(axis=1)
        dofs = [self.model().joint(name).dofadr[0] for name in self.joints]
        return Scales(
            torque=per_joint(lambda v: np.sqrt(np.mean(v**2)), torque) + 1e-6,
            inertia=self.inertia,
            velocity=per_joint(lambda v: np.sqrt(np.mean(v**2)), velocity) + 1e-6,
            peak_torque=per_joint(lambda v: np.abs(v).max(), torque) + 1e-6,
            peak_torque_rate=step * max(r.control_rate_hz for r in self.recordings) + 1e-6,
            control_rate_hz=max(r.control_rate_hz for r in self.recordings),
            range=per_joint(np.ptp, samples.q),
            kp=kp.max(axis=0),
            kd=kd.max(axis=0) + 1e-6,
            armature=self.model().dof_armature[dofs],
            friction=self.model().dof_frictionloss[dofs],
            damping=self.model().dof_damping[dofs],
        )

    @cached_property
    def inertia(self) -> np.ndarray:
        """Diagonal of the mass matrix where the first recording starts, (njoint,) kg·m²."""
        model = self.model()
        data = mujoco.MjData(model)
        data.qpos[[model.joint(name).qposadr[0] for name in self.joints]] = start_state(
            self.recordings[0]
        )[0]
        mujoco.mj_forward(model, data)
        mass = np.zeros((model.nv, model.nv))
        mujoco.mj_fullM(model, data, mass)
        return np.diag(mass)[[model.joint(name).dofadr[0] for name in self.joints]]

    def at_samples(self, signals: Sequence[np.ndarray]) -> np.ndarray:
        """(nsample,) values of signals (n, njoint), one a recording, where it was measured."""
        first = np.cumsum([0, *(len(signal) for signal in signals)])[self.samples.recording]
        return np.concatenate(signals)[first + self.samples.row, self.samples.joint]

    def by_row(self, values: np.ndarray) -> list[np.ndarray]:
        """Values (nsample,) as one array (n, njoint) a recording, NaN where not measured."""
        signals = [np.full_like(recording.q, np.nan) for recording in self.recordings]
        for i, signal in enumerate(signals):
            at = self.samples.recording == i
            signal[self.samples.row[at], self.samples.joint[at]] = values[at]
        return signals

    def gravity_at_samples(self, q: np.ndarray | None = None) -> np.ndarray:
        """Gravity torque N·m at each sample, (nsample,): what holding the arm still takes.

        Args:
            q: (nsample,) positions, rad; by default the measured ones.
        """
        model = self.model()
        data = mujoco.MjData(model)
        qpos = [model.joint(name).qposadr[0] for name in self.joints]
        dofs = [model.joint(name).dofadr[0] for name in self.joints]
        every = 1 + sum(len(r.time) for r in self.recordings) // GRAVITY_POSES
        positions = self.by_row(self.samples.q if q is None else q)
        signals, bias = [], np.empty(model.nv)
        for recording, position, measured in zip(
            self.recordings, positions, self._rows, strict=True
        ):
            rows = np.union1d(np.flatnonzero(measured)[::every], np.flatnonzero(measured)[-1:])
            known = np.empty((len(rows), len(dofs)))
            for i, row in enumerate(rows):
                data.qpos[qpos] = np.where(
                    np.isnan(position[row]), recording.q_des[row], position[row]
                )
                mujoco.mj_kinematics(model, data)
                mujoco.mj_comPos(model, data)
                mujoco.mj_comVel(model, data)
                mujoco.mj_rne(model, data, 0, bias)
                known[i] = bias[dofs]
            at = np.arange(len(recording.time))
            signals.append(np.column_stack([np.interp(at, rows, column) for column in known.T]))
        return self.at_samples(signals)


def check_finite(q: np.ndarray, predictor: Predictor) -> None:
    """Find a recording whose prediction q (nsample,) is not finite.

    Raises:
        DivergenceError: naming it, its gains and its rate.
    """
    bad = np.unique(predictor.samples.recording[~np.isfinite(q)])
    if len(bad):
        first = predictor.recordings[bad[0]]
        others = f" (and of {len(bad) - 1} more)" if len(bad) > 1 else ""
        raise DivergenceError(
            f"the simulation of {first.path or first.name}{others} diverges: with Kp up to "
            f"{first.kp.max():g} and Kd up to {first.kd.max():g} at {first.control_rate_hz:g} Hz "
            "the model runs away. Check these numbers in the recording's YAML, the inertias of "
            "the robot's MJCF and the effects of the model."
        )


def _ticks(elapsed: np.ndarray, period: float) -> tuple[np.ndarray, np.ndarray]:
    """The tick at or before each time, and the fraction of a period since it."""
    exact = elapsed / period
    below = np.floor(exact + 1e-6).astype(int)
    rest = np.clip(exact - below, 0.0, None)
    return below, np.where(rest < 1e-6, 0.0, rest)


def _structure(terms: Sequence[Term]) -> tuple:
    return tuple(sorted((term.effect.name, term.joints) for term in terms))


def _chunks(items: list, size: int) -> list[list]:
    return [items[i : i + size] for i in range(0, len(items), size)]


def _runs(chunk: list[tuple[int, int]]) -> list[tuple[int, list[int]]]:
    runs: list[tuple[int, list[int]]] = []
    for request, row in chunk:
        if not runs or runs[-1][0] != request:
            runs.append((request, []))
        runs[-1][1].append(row)
    return runs
