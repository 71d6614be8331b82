"""The numbers behind the page's plots, small enough to travel in it."""

import base64
from typing import Any

import numpy as np

from t2l.diagnose.conditions import CONDITIONS, LABELS, UNITS
from t2l.diagnose.fronts import Front, fronts
from t2l.diagnose.results import (
    Compared,
    Found,
    errors_by_step,
    kind_of,
    mapped,
    noise_density,
)
from t2l.diagnose.traces import Traces, binned, spectrum
from t2l.effects.law import LIMIT, MOTOR
from t2l.plotting.heatmap import error_limits

OVERLAY_SAMPLES = 60_000  # in all overlays together
COARSEST = 4  # every n-th sample; rather than coarser, fewer recordings are shown
FEWEST_RECORDINGS = 3
CLOUD_SAMPLES = 5_000  # per model, in all joints together


def payload(found: Found) -> dict[str, Any]:
    """Everything the page's script draws, JSON-able; arrays are base64 of float32."""
    content: dict[str, Any] = {}
    if found.diagnosis is not None:
        content["ranking"] = ranking(found.diagnosis)
    if found.explanation is not None:
        content["falling"] = falling(found)
        content["fronts"] = [front(one) for one in fronts(found)]
    if found.proposal is not None:
        content["curves"] = [curve(one) for one in found.proposal["curves"]]
    if found.compared:
        content |= _comparison(found)
    return content


def curve(one: dict[str, Any]) -> dict[str, Any]:
    """A learned curve with its band."""
    unit = f" [{one['unit']}]" if one["unit"] else ""
    share = one["kind"] == MOTOR
    title = "most delivered torque [N·m]" if one["kind"] == LIMIT else "delivered torque [N·m]"
    return {
        "title": f"{one['variable']}{unit}",
        "torque_title": "delivered over commanded torque, less 1" if share else title,
        "torque_unit": "" if share else " N·m",
        **{key: packed(one[key]) for key in ("at", "torque", "low", "high")},
    }


def ranking(diagnosis: dict[str, Any]) -> list[dict[str, Any]]:
    """Candidates with the fall of the error on what is left out, in per cent, the largest first."""
    entries = diagnosis["ranking"]
    return [
        {
            "title": entry["title"],
            "improvement": 100 * entry["improvement"]["fraction"],
            "ci95": [100 * bound for bound in entry["improvement"]["ci95"]],
            "kind": kind_of(entry, diagnosis),
        }
        for entry in sorted(entries, key=lambda entry: -entry["improvement"]["fraction"])
    ]


def front(one: Front) -> dict[str, Any]:
    """Sets that were compared in a round, errors in mrad."""
    return {
        "names": one.names,
        "numbers": [tried["numbers"] for tried in one.tried],
        "error": [1e3 * tried["left_out_rmse_q_rad"] for tried in one.tried],
        "simulated": [tried["simulated"] for tried in one.tried],
        "best": one.best,
        "before": 1e3 * one.before_rad,
        "adopted": one.adopted,
        "adopted_error": one.adopted_rad and 1e3 * one.adopted_rad,
    }


def falling(found: Found) -> dict[str, Any]:
    """Training and test error after every step, mrad."""
    names, train, test = zip(*errors_by_step(found), strict=True)
    return {
        "names": names,
        "train": [1e3 * left for left in train if left is not None],
        "test": [1e3 * left for left in test],
        "floor": 1e3 * found.explanation["noise_floor_rad"],
    }


def _comparison(found: Found) -> dict[str, Any]:
    first = found.compared[0]
    traces = first.traces
    shown = recordings_to_show(traces)
    step = max(1, -(-np.isin(traces.recording, shown).sum() // OVERLAY_SAMPLES))
    return {
        "joints": list(traces.joints),
        "models": [compared.label for compared in found.compared],
        "noise_density": noise_density(first),
        "overlays": [
            [_overlay(found, i, joint, step) for joint in range(len(traces.joints))] for i in shown
        ],
        "conditions": [
            {"name": name, "label": LABELS.get(name, name), "unit": UNITS[name]}
            for name in conditions_of(traces)
        ],
        "cells": [
            [_cell(cell, traces.joints) for cell in compared.numbers["cells"]]
            for compared in found.compared
        ],
        "cell_limits": _cell_limits(found),
        "clouds": [_clouds(compared) for compared in found.compared],
        "spectra": [
            [_spectrum(compared.traces, joint) for joint in range(len(traces.joints))]
            for compared in found.compared
        ],
    }


def conditions_of(traces: Traces) -> list[str]:
    """The conditions that the table holds, in the order of menus."""
    return [name for name in CONDITIONS if name in traces.columns]


def recordings_to_show(traces: Traces) -> list[int]:
    """Recordings whose overlays the page holds: all, or a few from the best to the worst."""
    count = len(traces.recordings)
    most = int(count * COARSEST * OVERLAY_SAMPLES / len(traces.joint))
    if most >= count:
        return list(range(count))
    squares = np.bincount(traces.recording, traces.error**2, count)
    order = np.argsort(squares / np.maximum(np.bincount(traces.recording, minlength=count), 1))
    at = np.linspace(0, count - 1, max(min(FEWEST_RECORDINGS, count), most)).round().astype(int)
    return sorted(order[np.unique(at)].tolist())


def worst(traces: Traces, shown: list[int]) -> list[int]:
    """Place in `shown` of the recording, and the joint, with the largest squared error."""
    shape = (len(traces.recordings), len(traces.joints))
    key = traces.recording * shape[1] + traces.joint
    squares = np.bincount(key, traces.error**2, np.prod(shape)).reshape(shape)[shown]
    return [int(i) for i in np.unravel_index(np.argmax(squares), squares.shape)]


def _overlay(found: Found, recording: int, joint: int, step: int) -> dict[str, Any]:
    traces = found.compared[0].traces
    at = traces.at(recording, joint)[::step]
    return {
        "time": packed(traces.columns["time"][at]),
        "command": packed(traces.columns["q_des"][at]),
        "measured": packed(traces.columns["q"][at]),
        "simulated": [packed(c.traces.columns["q_sim"][at]) for c in found.compared],
    }


def unmapped(compared: Compared) -> list[str]:
    """Joints that have one pair of gains in all recordings: a map over gains would be one cell."""
    return [joint for joint in compared.traces.joints if joint not in mapped(compared)]


def _cell_limits(found: Found) -> dict[int, tuple[float, float]]:
    """By joint, -1 for all together: the errors in mrad at which the colours of a map end."""
    first, joints = found.compared[0], found.compared[0].traces.joints
    floor = first.numbers["noise_floor_rad"]
    return {
        -1 if joint is None else joints.index(joint): error_limits(
            [
                1e3 * cell["rmse_q_rad"]
                for compared in found.compared
                for cell in compared.numbers["cells"]
                if cell["joint"] == joint
            ],
            floor and 1e3 * floor,
        )
        for joint in mapped(first)
    }


def _cell(cell: dict[str, Any], joints: tuple[str, ...]) -> list[float]:
    joint = -1 if cell["joint"] is None else joints.index(cell["joint"])
    return [joint, cell["kp"], cell["kd"], 1e3 * cell["rmse_q_rad"]]


def _clouds(compared: Compared) -> list[dict[str, Any]]:
    """Per joint a sample of points and the mean per bin, of error and missing torque."""
    traces, rng = compared.traces, np.random.default_rng(0)
    each = CLOUD_SAMPLES // len(traces.joints)
    clouds = []
    for joint in range(len(traces.joints)):
        at = np.flatnonzero(traces.joint == joint)
        some = np.sort(rng.choice(at, min(each, len(at)), replace=False))
        error, torque = 1e3 * traces.error, traces.columns["missing_torque"]
        cloud = {"error": packed(error[some]), "torque": packed(torque[some]), "over": {}}
        for name in conditions_of(traces):
            x = traces.columns[name]
            curves = {
                key: [packed(v) for v in binned(x[at], y[at])]
                for key, y in (("error", error), ("torque", torque))
            }
            cloud["over"][name] = {"x": packed(x[some]), **curves}
        clouds.append(cloud)
    return clouds


def _spectrum(traces: Traces, joint: int) -> list[str]:
    frequency, amplitude = spectrum(traces, joint)
    return [packed(frequency), packed(1e3 * amplitude)]


def packed(values: np.ndarray) -> str:
    """Little-endian float32 as base64."""
    return base64.b64encode(np.asarray(values, "<f4").tobytes()).decode()
