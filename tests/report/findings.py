"""Folders as `t2l compare`, `diagnose` and `explain` fill them, small and quick to make."""

import json
import shutil
from collections.abc import Callable
from functools import cache, wraps
from pathlib import Path
from tempfile import TemporaryDirectory

from t2l.diagnose.compare import compare, write
from t2l.identify.model import Model, write_model
from tests.diagnose.made import pendulum, swings

FRICTION = {"coulomb_friction": {"torque": {"hinge": 0.06}}}
PARAMETER = {"value": 0.0601, "ci95": [0.0595, 0.0607], "unit": "N·m", "meaning": "friction torque"}


def made_once(make: Callable[[Path], Path]) -> Callable[[Path], Path]:
    """`make`, run for the first folder only; others get copies."""

    @cache
    def first() -> TemporaryDirectory:
        folder = TemporaryDirectory()
        make(Path(folder.name))
        return folder

    @wraps(make)
    def copied(folder: Path) -> Path:
        return shutil.copytree(first().name, folder, dirs_exist_ok=True)

    return copied


@made_once
def compared(folder: Path) -> Path:
    """What `compare` leaves for a pendulum whose model lacks friction."""
    robot = pendulum(folder)
    write(compare(Model(robot), swings(robot, FRICTION, 5e-5)), folder)
    return folder


def errors(train: float, rest: float) -> dict[str, float]:
    """RMS errors of the three sets, rad."""
    parts = ("train", "validation", "test")
    return {f"{p}_rmse_q_rad": e for p, e in zip(parts, (train, rest, rest), strict=True)}


def step(errors, effects=(), titles=(), shares=(), tried=()):
    """Of explanation.json."""
    added = {"effects": list(effects), "titles": list(titles), "chosen_shares": list(shares)}
    return {**added, "dropped": [], "tried": list(tried), **errors}


def tried(titles, numbers, error, simulated=True):
    """A set that was compared, of explanation.json."""
    return {
        "titles": list(titles),
        "numbers": numbers,
        "left_out_rmse_q_rad": error,
        "simulated": simulated,
    }


# more than are shown unfolded, and the adopted one is not the best
FIRST_ROUND = [
    tried(["Coulomb friction", "armature"], 2, 6.9e-5),
    tried(["Coulomb friction"], 1, 7e-5),
    tried(["Stribeck friction"], 3, 7.2e-5),
    tried(["viscous friction"], 1, 4e-3),
    tried(["armature"], 1, 9.6e-3, simulated=False),
    tried(["command delay"], 1, 9.1e-3, simulated=False),
    tried(["payload"], 4, 8.8e-3, simulated=False),
    tried(["viscous friction", "command delay"], 2, 3.1e-3, simulated=False),
    tried(["a torque on hinge that follows its velocity"], 6, 1.9e-4, simulated=False),
]
LAST_ROUND = [
    tried(["armature"], 1, 6.8e-5),
    tried(["a torque on hinge that follows its position"], 2, 6.9e-5, simulated=False),
]


def candidate(name, title, fraction, spread=0.02, tied=(), parameters=None, simulated=True):
    return {
        "effect": name,
        "title": title,
        "joints": ["hinge"],
        "validation_rmse_q_rad": 0.01 * (1 - fraction),
        "test_rmse_q_rad": 0.01 * (1 - fraction) if simulated else None,
        "chosen_share": 0.8 if simulated else None,
        "improvement": {"fraction": fraction, "ci95": [fraction - spread, fraction + spread]},
        "parameters": parameters or {},
        "tied_with": list(tied),
        "simulated": simulated,
        "why": f"because of {title}",
        "notes": [],
    }


def diagnosis():
    """Content of a diagnosis.json, with a tie, one not simulated and one that makes all worse."""
    return {
        "verdict": "missing_effect",
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
            candidate("viscous_friction", "viscous friction", 0.4, simulated=False),
            candidate("armature", "armature", -3.0),
        ],
        "training_recordings": ["kp5", "kp20"],
        "test_recordings": ["kp80"],
        "remaining": ["41 % of the missing torque follows the position"],
        "separating_experiment": {"sentence": "Command a slow sine at Kp 5"},
    }


def diagnosed(folder: Path) -> Path:
    """What `diagnose` leaves."""
    (folder / "diagnosis.json").write_text(json.dumps(diagnosis()))
    return folder


@made_once
def explained(folder: Path) -> Path:
    """What `explain` leaves after one step."""
    robot = pendulum(folder)
    recordings = swings(robot, FRICTION, 5e-5)
    write(compare(Model(robot), recordings), folder / "before")
    write(compare(Model(robot, FRICTION), recordings), folder / "after")
    write_model(Model(robot, FRICTION), folder / "model.yaml")
    friction = ["coulomb_friction"], ["Coulomb friction"], [0.8]
    explanation = {
        "steps": [
            step(errors(0.011, 0.01)),
            step(errors(6e-5, 7e-5), *friction, tried=FIRST_ROUND),
        ],
        "then_tried": LAST_ROUND,
        "verdict": "unexplained",
        "noise_floor_rad": 5e-5,
        "final": True,
        "sentence": "The model lacks Coulomb friction. More is missing",
        "confounded": [],
        "parameters": [
            {
                "effect": "coulomb_friction", "title": "Coulomb friction", "joint": "hinge",
                "parameter": "torque", **PARAMETER,
            }
        ],
    }  # fmt: skip
    (folder / "explanation.json").write_text(json.dumps(explanation))
    return folder


def proposal() -> dict:
    """Content of a proposal.json with a curve and its formula."""
    at = [-0.5, 0.0, 0.5]
    return {
        "verdict": "law",
        "sentence": "The model lacks a torque on hinge that grows with its position.",
        "noise_floor_rad": 5e-5,
        "choice": {"baseline_rmse_q_rad": 1e-3, "rmse_q_rad": 6e-5},
        "report": {"baseline_rmse_q_rad": 7e-5, "rmse_q_rad": 8e-5, "recordings": ["kp80"]},
        "fitted_recordings": ["kp5", "kp20"],
        "curves": [
            {
                "name": "learned_torque_hinge_position",
                "law": "a torque on hinge that grows with its position",
                "kind": "torque", "joint": "hinge", "follows": "position", "of": "hinge",
                "variable": "position",
                "unit": "rad", "at": at, "torque": [-0.1, 0.0, 0.1],
                "low": [-0.11, -0.01, 0.09], "high": [-0.09, 0.01, 0.11],
                "formula": {
                    "effect": "formula_torque_hinge_position", "sentence": "a·x, a = 0.2 N·m/rad",
                    "report_rmse_q_rad": None,
                },
                "note": "",
            }
        ],
        "ceilings": [{"law": "a constant torque on hinge", "rmse_q_rad": 9e-4}],
    }  # fmt: skip


def proposed(folder: Path) -> Path:
    """What `propose` leaves."""
    (folder / "proposal.json").write_text(json.dumps(proposal()))
    return folder


def explained_with_proposal(folder: Path) -> Path:
    """What `explain` leaves that adopted a learned curve after an effect.

    The round that led to the curve dropped numbers from the best set afterwards.
    """
    path = explained(folder) / "explanation.json"
    content = json.loads(path.read_text())
    title = "a torque on hinge that follows its position"
    sets = [tried([title], numbers, error) for numbers, error in ((2, 6.8e-5), (5, 6.1e-5))]
    curve = ["learned_torque_hinge_position"], [title], [0.4]
    content["steps"].append(step(errors(5.6e-5, 6e-5), *curve, tried=sets))
    content["then_tried"] = []
    path.write_text(json.dumps(content))
    (folder / "proposal").mkdir()
    proposed(folder / "proposal")
    return folder
