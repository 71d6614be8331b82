"""Effects taken out of t2l's library one at a time: what is proposed in their place.

    python -m benchmarks.proposals propose|explain FOLDER [CASE ...]

Each case hides one torque on one joint, of a generator that shares no code with t2l. `propose`
learns it without any known effect. `explain` has all of them but the one that would name it
(`--without`), and shows whether another name is adopted in its place.
"""

import json
import shutil
import sys
import zlib
from dataclasses import dataclass
from pathlib import Path
from time import perf_counter

import numpy as np
import pandas as pd
import yaml

from benchmarks.hidden_effects.cases import ARM, PENDULUM, Case, make
from benchmarks.hidden_effects.effects import (
    Cogging,
    CoulombFriction,
    HiddenEffect,
    OddPositionTorque,
    PerJoint,
    QuadraticFriction,
    TorqueOffset,
    ViscousFriction,
    per_joint,
)


@dataclass
class ParallelSpring(HiddenEffect):
    """τ = −k (q − q0), k in N·m/rad and q0 in rad."""

    stiffness: PerJoint
    rest: float = 0.0

    def start(self, plant):
        self.k = per_joint(self.stiffness, plant.joints)

    def torque(self, state):
        return -self.k * (state.q - self.rest)


@dataclass
class PeriodicTorque(HiddenEffect):
    """τ = A sin(2π f t), t since the recording's start."""

    amplitude: PerJoint
    frequency_hz: float

    def start(self, plant):
        self.a, self.begin = per_joint(self.amplitude, plant.joints), None

    def torque(self, state):
        self.begin = state.t if self.begin is None else self.begin
        return self.a * np.sin(2 * np.pi * self.frequency_hz * (state.t - self.begin))


# dry friction, and what is dry friction for some values of its parameters
DRY = (
    "coulomb_friction",
    "dahl_friction",
    "directional_friction",
    "friction_drift",
    "friction_temperature",
    "load_dependent_friction",
    "lugre_friction",
    "stribeck_friction",
)
# a cable that is wound on one joint alone is a spring and a damper
SPRING = ("parallel_spring", "joint_coupling")
# name, effect, its numbers on a pendulum, its size on an arm, the names that say the same, what
# the torque follows
HIDDEN = (
    (
        "viscous", ViscousFriction, (0.03,), 0.08, ("viscous_friction", "joint_coupling"),
        ("velocity", "speed"),
    ),
    ("quadratic", QuadraticFriction, (0.02,), 0.04, ("quadratic_friction",), ("velocity", "speed")),
    ("cogging", Cogging, (0.05, 14.0), 0.06, ("cogging",), ("position",)),
    ("coulomb", CoulombFriction, (0.06,), 0.05, DRY, ("speed", "velocity", "constant")),
    ("offset", TorqueOffset, (0.03,), -0.05, ("torque_offset",), ("constant",)),
    ("spring", ParallelSpring, (0.15, 0.3), 0.3, SPRING, ("position",)),
    ("bump", OddPositionTorque, (0.06, 0.5, 0.1, 0.3, 0.6), 0.06, (), ("position",)),
    ("periodic", PeriodicTorque, (0.04, 0.73), 0.05, ("periodic_torque",), ("time",)),
)  # fmt: skip
SHORT = {"duration_s": 3.0, "physics_rate_hz": 4000}
ELBOW = {"cogging": (20.0, 0.7), "spring": (0.8,), "bump": (1.0, 0.1, 0.8, 0.5), "periodic": (0.9,)}


def cases() -> dict[str, tuple[Case, tuple[str, ...], str, tuple[str, ...]]]:
    """By name: the case, names to take away, and the joint and the variables that are right."""
    table = {}
    for kind, effect, numbers, size, names, variables in HIDDEN:
        for robot in (PENDULUM, ARM):
            name = f"{kind}_{robot}"
            joint = "hinge" if robot == PENDULUM else "elbow"
            hidden = effect(*numbers) if robot == PENDULUM else effect(
                {"elbow": size}, *ELBOW.get(kind, ())
            )  # fmt: skip
            case = Case(name, robot, (hidden,), zlib.crc32(name.encode()), SHORT)
            table[name] = case, names, joint, variables
    return table


def row(command: str, name: str, folder: Path) -> dict:
    """Run a command on a case."""
    case, names, joint, variables = cases()[name]
    where, out = folder / "cases" / name, folder / command / name
    if not (where / "truth.yaml").exists():
        make(case, where)
    shutil.rmtree(out, ignore_errors=True)
    began = perf_counter()
    content, adopted = found(command, where, out, names)
    seconds = perf_counter() - began
    curves = content["curves"]
    floor = content["noise_floor_rad"]
    right = bool(curves) and all(
        c["joint"] == joint and c["of"] == joint and c["follows"] in variables for c in curves
    )
    after = content["report"]["rmse_q_rad"]
    formula = next((c["formula"] for c in curves if c["formula"]), None)
    return {
        "case": name,
        "names adopted": ", ".join(adopted) or "–",
        "proposed": "; ".join(c["law"] for c in curves) or content["verdict"],
        "right": right,
        "before_mrad": 1e3 * _before(content, out),
        "names_mrad": 1e3 * content["report"]["baseline_rmse_q_rad"],
        "curve_mrad": 1e3 * after,
        "formula_mrad": 1e3 * formula["report_rmse_q_rad"] if formula else None,
        "noise_mrad": 1e3 * floor,
        "within_twice": after <= 2 * floor,
        "formula": formula["sentence"] if formula else "",
        "seconds": seconds,
    }


def found(command: str, where: Path, out: Path, without: tuple[str, ...]) -> tuple[dict, list]:
    """What is proposed, and the names that the model adopts in the end."""
    from t2l.cli.main import main
    from t2l.effects.registry import builtin

    taken = [name for name in without if name in builtin()]
    logs = [str(where / "train"), "--holdout", str(where / "holdout"), "--out", str(out)]
    if command == "propose":
        main([command, *logs])
        return json.loads((out / "proposal.json").read_text()), []
    main([command, *logs, *(f"--without={name}" for name in taken)])
    content = _proposed(out)
    model = yaml.safe_load((out / "model.yaml").read_text())
    return content, list(model["effects"])


def _proposed(out: Path) -> dict:
    """The proposal beside an explanation; without one, what the explanation says itself."""
    if (out / "proposal" / "proposal.json").exists():
        return json.loads((out / "proposal" / "proposal.json").read_text())
    told = json.loads((out / "explanation.json").read_text())
    errors = (told["steps"][at]["test_rmse_q_rad"] for at in (0, -1))
    report = dict(zip(("baseline_rmse_q_rad", "rmse_q_rad"), errors, strict=True))
    floor, verdict = told["noise_floor_rad"], told["verdict"]
    return {"curves": [], "noise_floor_rad": floor, "verdict": verdict, "report": report}


def _before(content: dict, out: Path) -> float:
    """Test error in rad of the model as it came."""
    if not (out / "explanation.json").exists():
        return content["report"]["baseline_rmse_q_rad"]
    return json.loads((out / "explanation.json").read_text())["steps"][0]["test_rmse_q_rad"]


def main(command: str, folder: Path, names: list[str]) -> None:
    """Print the table, kept after each case."""
    path, rows = folder / f"{command}.json", []
    for name in names or cases():
        rows.append(row(command, name, folder))
        print(json.dumps(rows[-1], ensure_ascii=False), flush=True)
        path.write_text(json.dumps(rows, indent=1, ensure_ascii=False))
    print(pd.DataFrame(rows).round(3).to_markdown(index=False))


if __name__ == "__main__":
    if len(sys.argv) < 3 or sys.argv[1] not in ("propose", "explain"):
        sys.exit(__doc__)
    main(sys.argv[1], Path(sys.argv[2]), sys.argv[3:])
