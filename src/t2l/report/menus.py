"""Menus above the plots: what they offer, and what is drawn at first."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from t2l.diagnose.conditions import LABELS
from t2l.diagnose.results import Compared, Found, mapped
from t2l.report.payload import conditions_of, recordings_to_show, worst
from t2l.report.words import mrad


@dataclass(frozen=True)
class Menu:
    """One choice for every plot of a name.

    Attributes:
        plot: name of the plots, as the page's script knows them.
        key: of the choice in the script.
        options: values for the script and texts for the reader.
        chosen: the value at first.
    """

    plot: str
    key: str
    label: str
    options: Sequence[tuple[Any, str]]
    chosen: Any


def menus(found: Found) -> dict[str, list[Menu]]:
    """The menus of each plot of a comparison; none for a map that would have one cell only."""
    compared = found.compared[0]
    joints = list(enumerate(compared.traces.joints))
    worst_joint = _worst_joint(compared)
    return {
        "cells": _of_cells(compared, joints, worst_joint),
        "overlay": _of_overlay(compared, joints),
        "conditions": _of_conditions(compared, joints, worst_joint),
        "spectrum": [Menu("spectrum", "joint", "joint", joints, worst_joint)],
    }


def _worst_joint(compared: Compared) -> int:
    shares = [compared.numbers["joints"][name]["share"] for name in compared.traces.joints]
    return shares.index(max(shares))


def _of_cells(compared: Compared, joints: list, worst_joint: int) -> list[Menu]:
    shown = mapped(compared)
    together = len(joints) > 1 and None in shown
    options = [(i, name) for i, name in joints if name in shown]
    if not options:
        return []
    chosen = worst_joint if worst_joint in dict(options) else options[0][0]
    if together:
        options, chosen = [(-1, "all together"), *options], -1
    return [Menu("cells", "joint", "joint", options, chosen)]


def _of_overlay(compared: Compared, joints: list) -> list[Menu]:
    names, logs = compared.traces.recordings, compared.numbers["logs"]
    shown = recordings_to_show(compared.traces)
    options = [
        (place, f"{names[i]} · {mrad(logs[i]['rmse_q_rad'])}") for place, i in enumerate(shown)
    ]
    recording, joint = worst(compared.traces, shown)
    return [
        Menu("overlay", "recording", "recording", options, recording),
        Menu("overlay", "joint", "joint", joints, joint),
    ]


def _of_conditions(compared: Compared, joints: list, worst_joint: int) -> list[Menu]:
    names = conditions_of(compared.traces)
    followed = [f["condition"] for f in compared.numbers["follows"] if f["condition"] in names]
    first = names.index(followed[0]) if followed else 0
    labels = [LABELS.get(name, name) for name in names]
    quantities = [("torque", "missing torque"), ("error", "position error")]
    return [
        Menu("conditions", "joint", "joint", joints, worst_joint),
        Menu("conditions", "condition", "against", list(enumerate(labels)), first),
        Menu("conditions", "quantity", "show", quantities, "torque"),
    ]
