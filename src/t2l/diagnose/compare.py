"""A model against recordings: every one simulated from its measured start, and what is left."""

import json
import logging
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, field, fields
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pa_parquet

from t2l.artefacts import whole, write_text
from t2l.diagnose import conditions
from t2l.diagnose.explained_variance import ExplainedVariance, explained_variance
from t2l.diagnose.files import COMPARISON, TRACES
from t2l.diagnose.findings import Finding, findings
from t2l.diagnose.inverse_dynamics_residual import missing_torque
from t2l.diagnose.measured_torque import TorqueSides, torque_sides
from t2l.diagnose.traces import column, labels
from t2l.errors import T2LError
from t2l.identify.loop_stability import Chatter, chattering
from t2l.identify.model import Model
from t2l.identify.noise_floor import noise_floor
from t2l.identify.prediction import Predictor, Request, check_finite
from t2l.identify.step_size import substeps_for
from t2l.recordings.contradictions import Contradiction, contradictions
from t2l.recordings.names import unique_names
from t2l.recordings.recording import Recording

logger = logging.getLogger(__name__)


@dataclass(frozen=True)
class Errors:
    """Measured minus predicted at every sample, (nsample,) each.

    Attributes:
        recording, joint: indices.
        kp, kd: gains of the sample's joint.
        q, dq: rad and rad/s; dq is NaN where velocity was not measured.
    """

    recording: np.ndarray
    joint: np.ndarray
    kp: np.ndarray
    kd: np.ndarray
    q: np.ndarray
    dq: np.ndarray

    def where(self, mask: np.ndarray) -> "Errors":
        """Those of some samples."""
        return Errors(*(getattr(self, f.name)[mask] for f in fields(self)))

    def rms(self) -> dict[str, float | None]:
        """`rmse_q_rad` and `rmse_dq_rad_s`, the latter None where no velocity was measured."""
        return {"rmse_q_rad": _rms(self.q), "rmse_dq_rad_s": _rms(self.dq)}


@dataclass(frozen=True)
class Comparison:
    """What was measured, what the model says, and where they part.

    Attributes:
        model: the model compared.
        recordings: what it was compared with.
        names: of the recordings, made unique.
        rmse_q_rad: over all measured positions.
        rmse_dq_rad_s: over all measured velocities; None where none was.
        noise_floor_rad: RMS error of a perfect model; None where it was not asked for.
        findings: joints and conditions that hold most of the squared error.
        explained: conditions by how much of the error they explain.
        contradictions: recordings that cannot both be true.
        chatter: of the model's loop, which makes the rest worthless; None if it settles.
        torque_sides: of each joint whose torque was measured, what that says of drive and machine.
        errors: at every sample.
        traces: a table, one row a sample: recording, joint, time, q_des, q, q_sim, dq (where
            measured), missing_torque and the conditions, in SI units, with 7 digits.
    """

    model: Model
    recordings: tuple[Recording, ...]
    names: tuple[str, ...]
    rmse_q_rad: float
    rmse_dq_rad_s: float | None
    noise_floor_rad: float | None
    findings: list[Finding]
    explained: list[ExplainedVariance]
    contradictions: list[Contradiction]
    chatter: Chatter | None
    torque_sides: list[TorqueSides]
    errors: Errors = field(repr=False)
    traces: pa.Table = field(repr=False)

    @property
    def joints(self) -> tuple[str, ...]:
        """Names, as in the recordings."""
        return self.recordings[0].joints

    @property
    def sentence(self) -> str:
        """The result, for people, and why it may be worth nothing."""
        return f"{self.chatter.sentence} {self.result}" if self.chatter else self.result

    @property
    def result(self) -> str:
        """How far the model is off, and where, for people."""
        error = f"The model is off by {1e3 * self.rmse_q_rad:.3g} mrad RMS"
        if self.noise_floor_rad is not None:
            error += f", of which measurement noise is {1e3 * self.noise_floor_rad:.2g} mrad"
        where = f"; {self.findings[0].sentence}" if self.findings else ""
        return f"{error}{where}."


def compare(
    model: Model,
    recordings: Sequence[Recording],
    noise: bool = True,
    progress: Callable[[float], None] = lambda part: None,
) -> Comparison:
    """Simulate every recording with its commands, gains and rates.

    Steps are as fine as this model needs for these recordings (`t2l.identify.step_size`), whoever
    asks.

    Args:
        noise: whether to estimate the noise floor and to look for contradictions beyond it.
        progress: told now and then which part of the simulation is done.

    Raises:
        DivergenceError: a simulation runs away.
        T2LError: recordings of different joints.
    """
    _check_joints(recordings)
    chatter = chattering(model, recordings)
    if chatter is not None:
        logger.warning("%s", chatter.sentence)  # before what may run away
    predictor = Predictor(model.robot, recordings, substeps_for(model, recordings))
    samples, joints = predictor.samples, predictor.joints
    layout, u = model.vector(joints)
    request = Request(layout, u[None])
    (q,), (dq,) = predictor.predict([request], velocity=True, progress=progress)
    q, dq = q[0], dq[0]
    names = unique_names(recordings)
    check_finite(q, predictor, request)
    residual = samples.q - q
    missing = missing_torque(predictor, residual)
    under = conditions.features(predictor, q, dq)
    measured_dq = predictor.samples.of(
        [np.full_like(r.q, np.nan) if r.dq is None else r.dq for r in recordings]
    )
    floor, contradicting = None, []
    if noise:
        floor = noise_floor(list(recordings), predictor.samples.by_row(residual))
        contradicting = contradictions(recordings, floor)
    return Comparison(
        model=model,
        recordings=tuple(recordings),
        names=names,
        rmse_q_rad=_rms(residual),
        rmse_dq_rad_s=_rms(measured_dq - dq),
        noise_floor_rad=floor,
        findings=findings(predictor, residual, under),
        explained=explained_variance(predictor, residual, under, missing),
        contradictions=contradicting,
        chatter=chatter,
        torque_sides=torque_sides(predictor),
        errors=Errors(
            samples.recording,
            samples.joint,
            predictor.samples.of([np.broadcast_to(r.kp, r.q.shape) for r in recordings]),
            predictor.samples.of([np.broadcast_to(r.kd, r.q.shape) for r in recordings]),
            residual,
            measured_dq - dq,
        ),
        traces=_traces(predictor, names, q, measured_dq, missing, under),
    )


def _traces(predictor: Predictor, names, q, measured_dq, missing, under) -> pa.Table:
    samples = predictor.samples
    columns = {
        "recording": labels(samples.recording, names),
        "joint": labels(samples.joint, predictor.joints),
    }
    numbers = {
        "time": samples.time,
        "q_des": samples.of([_commanded(r) for r in predictor.recordings]),
        "q": samples.q,
        "q_sim": q,
        "dq": measured_dq,
        "missing_torque": missing,
        **{name: values for name, values in under.items() if name not in ("time", "constant")},
    }
    if np.isnan(measured_dq).all():
        del numbers["dq"]
    columns |= {name: column(pa.float32(), values) for name, values in numbers.items()}
    return pa.table(columns)


def _commanded(recording: Recording) -> np.ndarray:
    """(n, njoint) rad; NaN where no position is commanded."""
    return np.full_like(recording.q_des, np.nan) if recording.drifts else recording.q_des


def report(comparison: Comparison) -> dict[str, Any]:
    """What `comparison.json` holds: numbers in SI units, and sentences."""
    errors = comparison.errors
    joints, total = comparison.joints, float(np.sum(errors.q**2)) or 1.0
    return {
        "rmse_q_rad": comparison.rmse_q_rad,
        "rmse_dq_rad_s": comparison.rmse_dq_rad_s,
        "noise_floor_rad": comparison.noise_floor_rad,
        "sentence": comparison.sentence,
        "robot": Path(comparison.model.robot).name,
        # for the page, which draws it
        "robot_file": comparison.model.robot,
        "effects": _plain(comparison.model.effects),
        "samples": len(errors.q),
        "logs": [
            _log(recording, name, errors.where(errors.recording == i), joints)
            for i, (recording, name) in enumerate(
                zip(comparison.recordings, comparison.names, strict=True)
            )
        ],
        "joints": {
            name: {**own.rms(), "share": float(np.sum(own.q**2) / total)}
            for j, name in enumerate(joints)
            for own in [errors.where(errors.joint == j)]
        },
        "cells": _cells(errors, joints),
        "findings": [asdict(f) | {"sentence": f.sentence} for f in comparison.findings],
        "follows": [asdict(f) | {"sentence": f.sentence} for f in comparison.explained],
        "chatter": comparison.chatter and comparison.chatter.sentence,
        "contradictions": [asdict(c) | {"message": c.message} for c in comparison.contradictions],
        "measured_torque": [sides.plain() for sides in comparison.torque_sides],
    }


def _log(recording: Recording, name: str, errors: Errors, joints: Sequence[str]) -> dict[str, Any]:
    return {
        "name": name,
        "kp": recording.kp.tolist(),
        "kd": recording.kd.tolist(),
        "duration_s": recording.duration_s,
        "command_rate_hz": recording.command_rate_hz,
        "control_rate_hz": recording.control_rate_hz,
        "gravity_compensation": bool(recording.gravity_compensation),
        "samples": len(errors.q),
        **errors.rms(),
        "joints": {
            joint: errors.where(errors.joint == j).rms()
            for j, joint in enumerate(joints)
            if (errors.joint == j).any()
        },
    }


def _cells(errors: Errors, joints: Sequence[str]) -> list[dict[str, Any]]:
    """RMS error of every joint under its own gains, and of all joints together (joint null)."""
    parts = [(None, errors)]
    parts += [(name, errors.where(errors.joint == j)) for j, name in enumerate(joints)]
    cells = []
    for joint, own in parts:
        # a recording has one pair of gains for each joint: few to sort, where samples are many
        _, first, label = np.unique(
            own.recording * len(joints) + own.joint, return_index=True, return_inverse=True
        )
        gains, cell = np.unique(
            np.stack([own.kp[first], own.kd[first]]), axis=1, return_inverse=True
        )
        cell = cell[label]
        for i, (kp, kd) in enumerate(gains.T.tolist()):
            cells.append({"joint": joint, "kp": kp, "kd": kd, **own.where(cell == i).rms()})
    return cells


def write(comparison: Comparison, folder: Path | str) -> None:
    """Write `comparison.json` and `traces.parquet` into a folder, each whole."""
    folder = Path(folder)
    with whole(folder / TRACES) as draft:
        pa_parquet.write_table(comparison.traces, draft, write_page_checksum=True)
    write_text(
        json.dumps(report(comparison), indent=1, ensure_ascii=False) + "\n", folder / COMPARISON
    )


def _rms(values: np.ndarray) -> float | None:
    values = values[~np.isnan(values)]
    return float(np.sqrt(np.mean(values**2))) if len(values) else None


def _plain(effects: Mapping) -> dict:
    return {
        key: _plain(value) if isinstance(value, Mapping) else float(value)
        for key, value in effects.items()
    }


def _check_joints(recordings: Sequence[Recording]) -> None:
    if not recordings:
        raise T2LError("no recordings to compare with")
    for recording in recordings[1:]:
        if recording.joints != recordings[0].joints:
            raise T2LError(
                f"{recording.path or recording.name} drives {', '.join(recording.joints)}, "
                f"{recordings[0].path or recordings[0].name} drives "
                f"{', '.join(recordings[0].joints)}; compare recordings of the same joints in the "
                "same order"
            )
