"""Folders as `t2l compare`, `diagnose` and `explain` fill them, small and quick to make."""

import json
from pathlib import Path

from t2l.diagnose.compare import compare, write
from t2l.identify.model import Model, write_model
from tests.diagnose.made import pendulum, swings

FRICTION = {"coulomb_friction": {"torque": {"hinge": 0.06}}}
PARAMETER = {"value": 0.0601, "ci95": [0.0595, 0.0607], "unit": "N·m", "meaning": "friction torque"}


def compared(folder: Path) -> Path:
    """What `compare` leaves for a pendulum whose model lacks friction."""
    robot = pendulum(folder)
    write(compare(Model(robot), swings(robot, FRICTION, 5e-5)), folder)
    return folder


def errors(train: float, rest: float) -> dict[str, float]:
    """RMS errors of the three sets, rad."""
    parts = ("train", "validation", "test")
    return {f"{p}_rmse_q_rad": e for p, e in zip(parts, (train, rest, rest), strict=True)}


def candidate(name, title, fraction, spread=0.02, tied=(), parameters=None):
    return {
        "effect": name,
        "title": title,
        "joints": ["hinge"],
        "validation_rmse_q_rad": 0.01 * (1 - fraction),
        "test_rmse_q_rad": 0.01 * (1 - fraction),
        "chosen_share": 0.8,
        "improvement": {"fraction": fraction, "ci95": [fraction - spread, fraction + spread]},
        "parameters": parameters or {},
        "tied_with": list(tied),
        "why": f"because of {title}",
        "notes": [],
    }


def diagnosis(verdict="missing_effect"):
    """Content of a diagnosis.json, with a tie and a candidate that makes everything worse."""
    return {
        "verdict": verdict,
        "sentence": "The model lacks Coulomb friction",
        "noise_floor_rad": 5e-5,
        "baseline": errors(0.011, 0.01),
        "ranking": [
            candidate(
                *("coulomb_friction", "Coulomb friction", 0.99),
                tied=["stribeck_friction"],
                parameters={"hinge.torque": PARAMETER},
            ),
            candidate("stribeck_friction", "Stribeck friction", 0.985, tied=["coulomb_friction"]),
            candidate("armature", "armature", -3.0),
        ],
        "training_recordings": ["kp5", "kp20"],
        "validation_recordings": ["kp20"],
        "test_recordings": ["kp80"],
        "remaining": ["41 % of the missing torque follows the position"],
        "separating_experiment": {"sentence": "Command a slow sine at Kp 5"},
    }


def diagnosed(folder: Path) -> Path:
    """What `diagnose` leaves."""
    (folder / "diagnosis.json").write_text(json.dumps(diagnosis()))
    return folder


def explained(folder: Path) -> Path:
    """What `explain` leaves after one step."""
    robot = pendulum(folder)
    recordings = swings(robot, FRICTION, 5e-5)
    write(compare(Model(robot), recordings), folder / "before")
    write(compare(Model(robot, FRICTION), recordings), folder / "after")
    write_model(Model(robot, FRICTION), folder / "model.yaml")
    for number, verdict in enumerate(("missing_effect", "unexplained")):
        (folder / "steps" / str(number)).mkdir(parents=True)
        path = folder / "steps" / str(number) / "diagnosis.json"
        path.write_text(json.dumps(diagnosis(verdict)))
    steps = [
        {"effect": None, "chosen_share": None, **errors(0.011, 0.01)},
        {"effect": "coulomb_friction", "chosen_share": 0.8, **errors(6e-5, 7e-5)},
    ]
    explanation = {
        "steps": steps,
        "verdict": "unexplained",
        "noise_floor_rad": 5e-5,
        "sentence": "Unexplained: something is left",
    }
    (folder / "explanation.json").write_text(json.dumps(explanation))
    return folder
