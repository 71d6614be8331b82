"""An experiment as files: what `t2l record` runs, and what it is expected to tell."""

import json
import os
from pathlib import Path
from typing import Any

from t2l.artefacts import write_text
from t2l.design.expected import Identifiability
from t2l.design.experiment import Experiment
from t2l.documents import to_yaml
from t2l.hardware.plan import Setup

PLAN, NUMBERS, TABLE = "plan.yaml", "plan.json", "expected_errors.csv"
TOLD_BEFOREHAND = "identifiability.json"
# what the chosen motions say instead
_REPLACED = ("name", "gains", "excitation", "motions")


def write_experiment(experiment: Experiment, setup: Setup, folder: Path) -> dict[str, Any]:
    """Write `PLAN`, `NUMBERS` and `TABLE`; returns the content of `NUMBERS`."""
    write_text(_plan(experiment, setup, folder), folder / PLAN)
    content = numbers(experiment)
    write_text(json.dumps(content, indent=2) + "\n", folder / NUMBERS)
    write_text(table(experiment.told), folder / TABLE)
    return content


def numbers(experiment: Experiment) -> dict[str, Any]:
    """The experiment, and what it will tell, as plain values."""
    return {
        "motions": [
            {
                "name": c.name, "moves": c.moved, "shape": c.shape,
                "amplitude_rad": c.section()["amplitude_rad"], "part_of_what_is_safe": peak,
            }
            for c, peak in zip(experiment.chosen, experiment.peaks, strict=True)
        ],
        "library": {"motions": experiment.considered, "unsafe": experiment.unsafe},
        "log_det": {
            "chosen": experiment.log_det, "best_single_motion": experiment.best_single,
            "mean_of_random_choices": experiment.random,
        },
        **experiment.told.as_json(),
    }  # fmt: skip


def table(told: Identifiability) -> str:
    """One row a parameter, as CSV."""
    rows = told.as_json()["parameters"]
    lines = [",".join(rows[0])] if rows else []
    lines += [",".join(_cell(value) for value in row.values()) for row in rows]
    return "\n".join(lines) + "\n"


def write_beforehand(told: Identifiability, folder: Path) -> None:
    """Write what a log can tell, before anything is fitted to it."""
    write_text(json.dumps(told.as_json(), indent=2) + "\n", folder / TOLD_BEFOREHAND)


def _plan(experiment: Experiment, setup: Setup, folder: Path) -> str:
    content = {key: value for key, value in setup.written.items() if key not in _REPLACED}
    if Path(setup.robot.name).is_absolute():
        content["robot"] = os.path.relpath(setup.robot.name, folder.resolve())
    content["motions"] = [
        {
            "name": c.name,
            "gains": {"kp": c.kp.tolist(), "kd": c.kd.tolist()},
            "excitation": c.section(),
        }
        for c in experiment.chosen
    ]
    body = to_yaml(content, sort_keys=False, allow_unicode=True, default_flow_style=None)
    return f"# by t2l plan; run it with: t2l record {PLAN} --out DIR\n{body}"


def _cell(value: Any) -> str:
    if value is None:
        return ""
    if isinstance(value, bool):
        return str(value).lower()
    return f"{value:.6g}" if isinstance(value, float) else str(value)
