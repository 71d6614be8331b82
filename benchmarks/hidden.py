"""What was hidden against what t2l named: every case of `benchmarks.hidden_effects`.

`python -m benchmarks hidden [--quick] [--test-seed N | --robots N] [CASE ...]`: the development
cases, or a test set that nobody has looked at, drawn from a seed, or one over more robots. Each
case is explained once and kept in results/bench/hidden_effects until the code changes that explains
it, so that an interrupted table goes on where it stopped.
"""

import argparse
import hashlib
import json
import os
import re
import shutil
from collections.abc import Sequence
from functools import partial
from itertools import permutations
from pathlib import Path
from time import perf_counter

import numpy as np
import pandas as pd
import yaml

from benchmarks import one_core
from benchmarks.hidden_effects.__main__ import write_case
from benchmarks.hidden_effects.cases import Case, cases
from benchmarks.hidden_effects.drawn_robots import cases_on_robots
from benchmarks.scene import ROOT

FOLDER = ROOT / "results/bench/hidden_effects"
PROCESSES = min(2, len(os.sched_getaffinity(0)))
# packages whose change redoes the table
EXPLAINS = ("sim", "robots", "effects", "identify", "diagnose", "propose", "detective")

# columns that an earlier table stands beside
COMPARED = ("named first", "right", "adopted", "test error after", "seconds")

# class in the generator: (its number, that of the effect in t2l)
NUMBERS = {
    "Armature": ("inertia", "inertia"),
    "CoulombFriction": ("level", "torque"),
    "ViscousFriction": ("coefficient", "damping"),
    "QuadraticFriction": ("coefficient", "coefficient"),
    "StribeckFriction": ("coulomb", "coulomb"),
    "TorqueOffset": ("offset", "torque"),
    "Payload": ("mass", "mass"),
    "TorqueConstant": ("factor", "factor"),
    "CommandDelay": ("delay_s", "delay"),
    "ActuatorBandwidth": ("frequency_hz", "cutoff"),
    "TorqueSaturation": ("limit", "limit"),
    "TorqueRateLimit": ("rate", "rate"),
    "ControllerGains": ("kp_factor", "kp_factor"),
    "LowRateLoop": ("rate_hz", "rate"),
    "EncoderOffset": ("offset", "offset"),
    "JointFlexibility": ("stiffness", "stiffness"),
    "Backlash": ("width", "play"),
    "Cogging": ("periods", "periods"),
    "ParallelSpring": ("stiffness", "stiffness"),
    "BaseTilt": ("pitch", "pitch"),
    "IntegralAction": ("gain", "gain"),
    "VelocityFilter": ("frequency_hz", "cutoff"),
    "DahlFriction": ("coulomb", "coulomb"),
    "LugreFriction": ("coulomb", "coulomb"),
    "DirectionalFriction": ("forward", "forward"),
    "TorqueSpeedLimit": ("stall_torque", "stall_torque"),
    "PeriodicTorque": ("frequency_hz", "frequency"),
    "FrictionDrift": ("end_level", "at_end"),
    "TorqueConstantDrift": ("at_end", "at_end"),
    "FrictionTemperature": ("level", "torque"),
    "TorqueConstantTemperature": ("per_kelvin", "per_kelvin"),
}


def main(arguments: Sequence[str]) -> pd.DataFrame:
    """What the command line asks for."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks hidden", description=__doc__)
    parser.add_argument("names", nargs="*", metavar="CASE", help="cases (default: all)")
    one_core.add_processes(parser, PROCESSES)
    earlier = "table.csv or folder results/ of another run, to compare with"
    parser.add_argument("--earlier", type=Path, metavar="TABLE", help=earlier)
    seed = "the test set that is drawn from this number, in place of the development cases"
    seeds = parser.add_mutually_exclusive_group()
    seeds.add_argument("--test-seed", type=int, metavar="N", help=seed)
    more = "the set over more robots, each with one to five effects, that is drawn from this number"
    seeds.add_argument("--robots", type=int, metavar="N", help=more)
    quick = "explain as `t2l explain --quick` does; the table has a name of its own"
    parser.add_argument("--quick", action="store_true", help=quick)
    given = parser.parse_args(arguments)
    if given.robots is None:
        drawn = cases(given.test_seed)
        name = "table" if given.test_seed is None else f"table_test{given.test_seed}"
    else:
        drawn, name = cases_on_robots(given.robots), f"table_robots{given.robots}"
    return run(drawn, name, given.names, given.processes, given.earlier, given.quick)


def run(
    drawn: Sequence[Case],
    name: str,
    names: Sequence[str] = (),
    processes: int = PROCESSES,
    earlier: Path | None = None,
    quick: bool = False,
) -> pd.DataFrame:
    """One row a case; a summary is printed above.

    Args:
        name: of the table's file.
        names: of the drawn cases; all if none.
        quick: by `t2l.detective`.
        earlier: table.csv, or the folder results/, of another run, whose errors and times stand
            beside the new ones.
    """
    unknown = set(names) - {case.name for case in drawn}
    if unknown:
        raise SystemExit(f"no case {', '.join(sorted(unknown))}")
    before = None if earlier is None else read_table(earlier)
    chosen = [case for case in drawn if not names or case.name in names]
    results = []
    for result in one_core.each(partial(judged, quick=quick), chosen, processes):
        results.append(result)
        print(f"{len(results)} of {len(chosen)}: {result['case']}, {result['first']}", flush=True)
    print("\n" + "\n".join(summary(results)) + "\n")
    table = pd.DataFrame([row(result) for result in results])
    name += "_quick" if quick else ""
    table.to_csv(FOLDER / f"{name}.csv", index=False)
    if before is not None:
        old = before.set_index("case").reindex(table["case"])
        for column in COMPARED:
            table[f"{column}, earlier"] = old[column].to_numpy()
    (FOLDER / f"{name}.md").write_text(table.to_markdown(index=False) + "\n")
    return table


def read_table(path: Path) -> pd.DataFrame:
    """A table as `run` wrote it, or made of the results that it kept."""
    if path.is_dir():
        files = sorted(path.glob("*.json"))
        return pd.DataFrame([row(json.loads(file.read_text())) for file in files])
    return pd.read_csv(path)


def judged(case, quick: bool = False) -> dict:
    """A case's result, from its file or made now."""
    path = FOLDER / ("quick" if quick else "results") / f"{case.name}.json"
    key = code_key()
    if path.exists():
        kept = json.loads(path.read_text())
        if kept["key"] == key and kept["truth"] == json.loads(json.dumps(case.truth())):
            return kept
    write_case(case, FOLDER / "cases")
    explain = explained_quickly if quick else explained
    result = {"key": key, "truth": case.truth(), **explain(FOLDER / "cases" / case.name)}
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(json.dumps(result, indent=1))
    return json.loads(path.read_text())


def code_key() -> str:
    """A digest of the code that the table judges."""
    digest = hashlib.sha256()
    for package in EXPLAINS:
        for file in sorted((ROOT / "src/t2l" / package).rglob("*.py")):
            digest.update(file.read_bytes())
    return digest.hexdigest()[:16]


def explained(folder: Path) -> dict:
    """Explain the recordings of `folder` as a user would, and fit what was really hidden."""
    # here, so that listing cases does not import the simulator in the parent
    from t2l.diagnose.evidence import gather
    from t2l.diagnose.forward_selection import explain
    from t2l.propose.beside import proposed_beside

    from t2l.diagnose.files import PROPOSAL, PROPOSED

    began = perf_counter()
    truth, model, recordings, holdout, substeps = _read(folder)
    evidence = gather(model.robot, recordings, holdout, substeps, threads=1)
    work = FOLDER / "work" / folder.name
    shutil.rmtree(work, ignore_errors=True)  # steps of other code
    found = explain(model, evidence, work)
    left = found.steps[-1].test_rmse_rad
    found = proposed_beside(model, found, evidence, work)
    proposal = work / PROPOSED / PROPOSAL
    curves, learned = [], None
    if proposal.exists():
        content = json.loads(proposal.read_text())
        curves = [curve["law"] for curve in content["curves"]]
        learned = content["report"]["rmse_q_rad"] if curves else None
    seconds = perf_counter() - began
    step = json.loads((work / "steps/0/diagnosis.json").read_text())
    first = step["ranking"][0] if step["ranking"] else None
    hidden = [snake(entry["effect"]) for entry in truth["hidden"]]
    return {
        "case": folder.name,
        "robot": truth["robot"],
        "hidden": hidden,
        "known": all(name in model.known_effects() for name in hidden),
        "verdict": step["verdict"],
        "first": first["effect"] if first else None,
        "tied": first["tied_with"] if first else [],
        "adopted": [name for s in found.steps for name in s.effects],
        "chosen": [share for s in found.steps for share in s.chosen_shares if share is not None],
        "final_verdict": found.verdict,
        "before": found.steps[0].test_rmse_rad,
        "after": left,
        "stand": list(found.model.effects),
        "partial": list(found.partial.effects) if found.partial else [],
        "curves": curves,
        "after_with_curves": learned,
        "oracle": oracle(model, evidence, hidden, step["ranking"]),
        "noise_floor": found.noise_floor_rad,
        "recovered": recovered(truth["hidden"], step["ranking"], found.model),
        "seconds": seconds,
    }


def _read(folder: Path) -> tuple:
    """Truth, model, recordings, those held out, and physics steps a tick."""
    from t2l.diagnose.recordings_and_model import read_recordings_and_model
    from t2l.identify.step_size import substeps_for

    truth = yaml.safe_load((folder / "truth.yaml").read_text())
    read = read_recordings_and_model([folder / "train"], [folder / "holdout"])
    return truth, *read, substeps_for(*read[:2])


def explained_quickly(folder: Path) -> dict:
    """Explain the recordings of `folder` as `t2l explain --quick` does."""
    from t2l.detective.data_split import split
    from t2l.detective.explanation import explained_quickly

    began = perf_counter()
    truth, model, recordings, holdout, substeps = _read(folder)
    data = split(model.robot, recordings, holdout, substeps, threads=1)
    found = explained_quickly(model, data)
    seconds = perf_counter() - began
    adopted = [name for s in found.steps for name in s.effects]
    hidden = [snake(entry["effect"]) for entry in truth["hidden"]]
    return {
        "case": folder.name,
        "robot": truth["robot"],
        "hidden": hidden,
        "known": all(name in model.known_effects() for name in hidden),
        "verdict": "missing_effect" if adopted else found.verdict,
        "first": adopted[0] if adopted else None,
        "tied": adopted[1:],
        "adopted": adopted,
        "chosen": [share for s in found.steps for share in s.chosen_shares if share is not None],
        "final_verdict": found.verdict,
        "before": found.steps[0].test_rmse_rad,
        "after": found.steps[-1].test_rmse_rad,
        "stand": list(found.model.effects),
        "partial": [],
        "curves": [],
        "after_with_curves": None,
        "oracle": None,
        "noise_floor": found.noise_floor_rad,
        "recovered": recovered(truth["hidden"], [], found.model),
        "seconds": seconds,
    }


def oracle(model, evidence, hidden: list[str], ranking: list[dict]) -> float | None:
    """Test RMSE in rad with exactly the hidden effects fitted; None if t2l knows not all.

    Of several, the least of all orders in which they are fitted.
    """
    if len(hidden) == 1:
        errors = {entry["effect"]: entry["test_rmse_q_rad"] for entry in ranking}
        return errors.get(hidden[0])
    if not hidden or any(name not in model.known_effects() for name in hidden):
        return None
    errors = [_in_turn(model, evidence, order) for order in permutations(hidden)]
    return min((error for error in errors if error is not None), default=None)


def _in_turn(model, evidence, names: Sequence[str]) -> float | None:
    """Test RMSE in rad with these effects adopted in this order; None if one cannot be."""
    from t2l.diagnose.ranking import adopt, diagnose

    error, known = None, model.known_effects()
    for name in names:
        diagnosis = diagnose(model, evidence, [known[name]])
        if not diagnosis.ranking:
            return None
        error = diagnosis.ranking[0].test_rmse_rad
        model = adopt(diagnosis, name)
    return error


def recovered(hidden: list[dict], ranking: list[dict], model) -> dict[str, float]:
    """Relative error of each hidden number, worst joint, in the final model."""
    errors = {}
    for entry in hidden:
        name = snake(entry["effect"])
        if entry["effect"] not in NUMBERS or name not in model.effects:
            continue
        theirs, ours = NUMBERS[entry["effect"]]
        value, truth = model.effects[name][ours], entry[theirs]
        if isinstance(truth, dict) and isinstance(value, dict):
            pairs = [(value.get(j, 0.0), t) for j, t in truth.items() if t]
        else:
            value = next(iter(value.values())) if isinstance(value, dict) else value
            truth = next(iter(truth.values())) if isinstance(truth, dict) else truth
            pairs = [(value, truth)]
        errors[name] = float(max(abs(v - t) / abs(t) for v, t in pairs))
    return errors


def snake(name: str) -> str:
    """CommandDelay → command_delay."""
    return re.sub(r"(?<!^)(?=[A-Z])", "_", name).lower()


def right(result: dict) -> bool:
    """A hidden effect first, or tied first; for an unknown one and none, the right verdict."""
    if not result["hidden"]:
        return result["verdict"] == "no_missing_effect"
    if not result["known"]:
        return result["final_verdict"] == "unexplained"
    named = bool(set(result["hidden"]) & {result["first"], *result["tied"]})
    return named and result["verdict"] == "missing_effect"


def summary(results: list[dict]) -> list[str]:
    """The aims and how far they are met."""
    known = [r for r in results if r["hidden"] and r["known"]]
    clean = [r for r in results if not r["hidden"]]
    unknown = [r for r in results if not r["known"]]
    named = [r for r in known if right(r)]
    near = [r for r in known if r["oracle"] and r["after"] <= 1.1 * r["oracle"]]
    lines = []
    for what, group, good in (
        ("hidden effect first or tied first", known, named),
        ("of these without a tie", known, [r for r in named if r["first"] in r["hidden"]]),
        ("test error after within 10 % of the oracle's", known, near),
        (
            "no name of a known effect taken for a part",
            known,
            [r for r in known if not r["partial"]],
        ),
        ("no false alarm on clean cases", clean, [r for r in clean if right(r)]),
        ("unexplained in the end on unknown effects", unknown, [r for r in unknown if right(r)]),
    ):
        if group:
            lines.append(f"{what}: {len(good)} of {len(group)} ({len(good) / len(group):.0%})")
    return lines


def row(result: dict) -> dict:
    """What the table shows, errors in mrad."""

    def mrad(value):
        return "" if value is None else f"{1e3 * value:.3f}"

    tied = f" (= {', '.join(result['tied'])})" if result["tied"] else ""
    worst = max(result["recovered"].values(), default=np.nan)
    return {
        "case": result["case"],
        "hidden": " + ".join(result["hidden"]) or "nothing",
        "named first": (result["first"] + tied)
        if result["verdict"] == "missing_effect"
        else result["verdict"],
        "right": "yes" if right(result) else "NO",
        "adopted": " + ".join(result["adopted"]) or "nothing",
        "in the end": result["final_verdict"],
        "explain a part": " + ".join(result.get("partial", [])),
        "proposed": "; ".join(result.get("curves", [])),
        "chosen in": ", ".join(f"{share:.0%}" for share in result.get("chosen", [])),
        "before": mrad(result["before"]),
        "test error after": mrad(result["after"]),
        "seconds": f"{result['seconds']:.0f}",
        "oracle": mrad(result["oracle"]),
        "noise": mrad(result["noise_floor"]),
        "parameter off by": "" if np.isnan(worst) else f"{worst:.1%}",
    }
