"""What advice leaves for programs: advice.json, and gains.yaml for a controller."""

import json
from pathlib import Path
from typing import Annotated

import numpy as np
from pydantic import Field

from t2l.advise.advice import Advice
from t2l.advise.exclusions import Objection
from t2l.artefacts import write_text
from t2l.documents import to_yaml
from t2l.typed import AsTuple, Number, Typed, check

ADVICE, GAINS = "advice.json", "gains.yaml"
HEAD = "# tau = kp (q_des - q) - kd dq; N·m/rad and N·m·s/rad; advised by t2l, see report.html\n"

Known = Number | None


class Reason(Typed):
    """What a joint has against a pair of gains."""

    joint: str
    kind: str
    why: str


class CellEntry(Typed):
    """One pair of gains; numbers are of the worst joint, null where they are not known.

    Attributes:
        hopeless: by its predicted error.
        excluded, costs: what rules it out, and what its predicted error weighs.
        chance_best_is_better: share of measured pairs that differed as much in which the better
            one by prediction was it.
    """

    kp: Number
    kd: Number
    as_good: bool
    hopeless: bool
    predicted_error_rad: Known
    chance_best_is_better: Known
    expected_success: Annotated[Known, Field(description="after trainings")]
    ring_hz: Number
    overshoot: Known
    margin: Number
    lag_s: Number
    lead_rad: Known
    replay_rmse_rad: Known
    excluded: Annotated[tuple[Reason, ...], AsTuple]
    costs: Annotated[tuple[Reason, ...], AsTuple]


class JointEntry(Typed):
    """What is advised for a joint, and how it answers there."""

    kp: Number
    kd: Number
    natural_hz: Number
    overshoot: Known
    margin: Number
    lag_s: Number
    action_scale_rad: Annotated[
        tuple[Known, Known] | None, AsTuple, Field(description="least and largest, null if unknown")
    ]


class AdviceFile(Typed):
    """advice.json."""

    robot: str
    control_rate_hz: Number
    policy_rate_hz: Number
    gravity_compensation: bool
    torques: Annotated[str | None, Field(description="where those of demonstrations are from")]
    effects: Annotated[tuple[str, ...], AsTuple]
    not_in_the_linear_loop: Annotated[tuple[str, ...], AsTuple]
    joints: dict[str, JointEntry]
    cells: Annotated[tuple[CellEntry, ...], AsTuple]


def write_advice(advice: Advice, folder: Path) -> None:
    """Write both files."""
    content = as_file(advice).model_dump(mode="json")
    write_text(json.dumps(content, indent=1, allow_nan=False) + "\n", folder / ADVICE)
    joints = {
        name: {"kp": float(f"{kp:.6g}"), "kd": float(f"{kd:.6g}")}
        for name, (kp, kd) in zip(advice.asked.joints, advice.gains, strict=True)
    }
    content = {
        "robot": advice.asked.model.robot, "control_rate_hz": advice.machine.rate_hz,
        "joints": joints,
    }  # fmt: skip
    write_text(HEAD + to_yaml(content, sort_keys=False), folder / GAINS)


def as_file(advice: Advice) -> AdviceFile:
    """The typed document."""
    asked, machine = advice.asked, advice.machine
    return check(
        AdviceFile,
        {
            "robot": asked.model.robot,
            "control_rate_hz": machine.rate_hz,
            "policy_rate_hz": float(asked.policy_rate_hz),
            "gravity_compensation": asked.compensated,
            "torques": asked.shown and asked.shown.torques,
            "effects": list(asked.model.effects),
            "not_in_the_linear_loop": list(machine.left_out),
            "joints": {name: _joint(advice, j) for j, name in enumerate(asked.joints)},
            "cells": [_cell(advice, i) for i in range(len(advice.score))],
        },
    )


def _joint(advice: Advice, j: int) -> dict:
    at, found = (advice.cells[j], j), advice.responses
    kp, kd = advice.gains[j]
    return {
        "kp": float(kp), "kd": float(kd), "natural_hz": float(found.natural_hz[at]),
        "overshoot": _known(found.overshoot[at]), "margin": float(found.margin[at]),
        "lag_s": float(found.lag_s[at]), "action_scale_rad": _scale(advice, at),
    }  # fmt: skip


def _scale(advice: Advice, at: tuple[int, int]) -> list[float | None] | None:
    scales = advice.scales
    return scales and [_known(scales.low[at]), _known(scales.high[at])]


def _cell(advice: Advice, i: int) -> dict:
    cell, found, cloning = advice.asked.grid.cells[i], advice.responses, advice.cloning
    worst = int(np.argmax(found.overshoot[i]))
    return {
        "kp": float(cell.kp),
        "kd": float(cell.kd),
        "as_good": bool(advice.as_good[i]),
        "hopeless": bool(advice.hopeless[i]),
        "predicted_error_rad": cloning and _known(cloning.error[i]),
        "chance_best_is_better": cloning and float(advice.chance()[i]),
        "expected_success": advice.settled and float(advice.settled.believed.mean[i]),
        "ring_hz": float(found.ring_hz[i, worst]),
        "overshoot": _known(found.overshoot[i].max()),
        "margin": float(found.margin[i].min()),
        "lag_s": float(found.lag_s[i].max()),
        "lead_rad": cloning and _known(cloning.labels.lead_rad[i].max()),
        "replay_rmse_rad": cloning and _known(cloning.replay.rmse_rad[i].max()),
        "excluded": _reasons(advice, advice.ruling, i),
        "costs": _reasons(advice, advice.costing, i),
    }


def _reasons(advice: Advice, told: list[Objection], i: int) -> list[dict]:
    return [
        {"joint": advice.asked.joints[one.joint], "kind": one.kind, "why": one.why}
        for one in told
        if one.cell == i
    ]


def _known(value: float) -> float | None:
    return float(value) if np.isfinite(value) else None
