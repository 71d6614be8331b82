"""The folder of an exported model."""

import json
from pathlib import Path
from typing import Any

import numpy as np

from t2l.artefacts import write_text
from t2l.effects.term import Layout
from t2l.export.mjcf import Controller, export
from t2l.export.ranges import ranges
from t2l.export.robot_files import robot_data, robot_text
from t2l.identify.model import Model
from t2l.identify.uncertainty import Uncertainty

MJCF, ROBOT, DATA, SUMMARY = "model.xml", "robot.py", "robot.json", "export.json"
ENTRIES = (MJCF, ROBOT, DATA, SUMMARY)


def write_export(
    model: Model,
    controller: Controller,
    layout: Layout,
    u: np.ndarray,
    found: Uncertainty | None,
    folder: Path,
) -> dict[str, Any]:
    """Write model.xml, robot.py, robot.json and export.json; what the last holds is returned.

    Args:
        u: values of the effects.
        found: a refit's, whose intervals become ranges; None without recordings.
    """
    to = export(model, controller, layout, u)
    to.spec.compile()
    carried = [term.effect.name for term in layout.terms]
    by_callback = [name for name in carried if name in to.by_callback]
    lost = dict(to.lost)
    content = {
        "robot": model.robot if Path(model.robot).suffix == "" else Path(model.robot).name,
        "joints": list(controller.joints),
        "kp": controller.kp.tolist(),
        "kd": controller.kd.tolist(),
        "timestep_s": to.period_s,
        "gravity_compensation": controller.gravity_compensation,
        "in_mjcf": [n for n in carried if n not in (*by_callback, *lost, *to.of_log)],
        "by_callback": by_callback,
        "of_the_log": to.of_log,
        "log_lead_s": to.log_lead_s,
        "not_carried": lost,
        "note": (
            "The MJCF moves as the recordings only with integrator Euler and this timestep. It has "
            "no geoms: put the attributes of its joints, bodies and actuators into a file with "
            "shapes where contacts matter. Delayed actuators begin with commands of zero: start "
            "them with mj_initCtrlHistory, as robot.py does."
        ),
        "ranges": ranges(model, controller, found) if found is not None else None,
    }
    write_text(to.spec.to_xml(), folder / MJCF)
    write_text(robot_text(to), folder / ROBOT)
    write_text(json.dumps(robot_data(to)) + "\n", folder / DATA)
    write_summary(content, folder)
    return content


def write_summary(content: dict[str, Any], folder: Path) -> None:
    """Write export.json."""
    write_text(json.dumps(content, indent=1, ensure_ascii=False) + "\n", folder / SUMMARY)
