"""What was hidden against what t2l named: every case of `benchmarks.hidden_effects`.

`python -m benchmarks hidden [--test-seed N | --robots N] [--only-true] [--limit S] [CASE ...]`: the
development cases, or a test set that nobody has looked at, drawn from a seed, or one over more
robots. A search that takes longer than the limit ends with the best so far. Seconds are of a core.
Each name of a case, what was named and the errors go to a CSV, the counts are printed. With
`--only-true` t2l knows no effect but those that are hidden, beside curves: what is left then is not
of a wrong name, but of the fit or the physics. Cases with an effect that t2l lacks are left out.
Each case is explained once, as `t2l explain` does, and kept in results/bench/hidden_effects until
the code changes that explains it, so that an interrupted table goes on where it stopped.
"""

import argparse
import hashlib
import json
import os
import re
from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from time import process_time

import numpy as np
import pandas as pd
import yaml

from benchmarks import one_core
from benchmarks.hidden_effects.__main__ import write_case
from benchmarks.hidden_effects.as_t2l import ALIKE, CALLED
from benchmarks.hidden_effects.cases import VISIBLE, Case, cases
from benchmarks.hidden_effects.drawn_robots import cases_on_robots
from benchmarks.scene import ROOT
from t2l.artefacts import write_text

FOLDER = ROOT / "results/bench/hidden_effects"
PROCESSES = min(2, len(os.sched_getaffinity(0)))
LIMIT_S = 180
# packages whose change redoes the table
EXPLAINS = ("sim", "robots", "effects", "identify", "diagnose", "propose", "detective")

# columns that an earlier table stands beside
COMPARED = ("right", "adopted", "curves", "test error after", "seconds")
TWICE = 2.0  # times the noise that is left where all is explained
NEAR = 1.2  # likewise, where effects and their numbers are right
WORSE = 1.02  # times the error before, at which one is larger

# class in the generator: (its number, that of the effect in t2l)
NUMBERS = {kind: next((theirs, ours) for ours, theirs in of.items()) for kind, of in ALIKE.items()}
NUMBERS |= {kind: ("coulomb", "coulomb") for kind in ("StribeckFriction", "LugreFriction")}
NUMBERS["Payload"] = ("mass", "mass")
# how many known effects at once
AT_ONCE = {"one": (1, 1), "two at once": (2, 2), "three or more": (3, 9)}


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
    true = "let t2l know those effects alone that are hidden"
    parser.add_argument("--only-true", action="store_true", help=true)
    longest = "the longest search, in seconds of a core"
    parser.add_argument("--limit", type=float, default=LIMIT_S, metavar="S", help=longest)
    given = parser.parse_args(arguments)
    if not given.limit > 0:
        parser.error(f"--limit: found {given.limit:g}; allowed: above 0 s")
    if given.robots is None:
        drawn = cases(given.test_seed)
        name = "table" if given.test_seed is None else f"table_test{given.test_seed}"
    else:
        drawn, name = cases_on_robots(given.robots), f"table_robots{given.robots}"
    if given.only_true:
        drawn, name = [case for case in drawn if is_known(case)], f"{name}_only_true"
    return run(
        drawn, name, given.names, given.processes, given.earlier, given.only_true, given.limit
    )


def run(
    drawn: Sequence[Case],
    name: str,
    names: Sequence[str] = (),
    processes: int = PROCESSES,
    earlier: Path | None = None,
    only_true: bool = False,
    limit_s: float = LIMIT_S,
) -> pd.DataFrame:
    """One row a case; a summary is printed above.

    Args:
        name: of the table's file.
        names: of the drawn cases; all if none.
        earlier: table.csv, or the folder results/, of another run, whose errors and times stand
            beside the new ones.
    """
    unknown = set(names) - {case.name for case in drawn}
    if unknown:
        raise SystemExit(f"no case {', '.join(sorted(unknown))}")
    before = None if earlier is None else read_table(earlier)
    chosen = [case for case in drawn if not names or case.name in names]
    # what lacks most takes longest: begun last it would keep one core busy at the end
    queue = sorted(chosen, key=lambda case: -len(case.hidden))
    results = []
    judge = partial(judged, only_true=only_true, limit_s=limit_s)
    for result in one_core.each(judge, queue, processes):
        results.append(result)
        found = _listed([*result.get("stand", ()), *result.get("curves", ())])
        print(f"{len(results)} of {len(queue)}: {result['case']}, {found}", flush=True)
    place = {case.name: i for i, case in enumerate(chosen)}
    results.sort(key=lambda result: place[result["case"]])
    for result in (r for r in results if "failed" in r):
        print(f"left out: {result['case']}, {result['failed']}")
    results = [result for result in results if "failed" not in result]
    print("\n" + summary(results).to_markdown(index=False) + "\n")
    table = pd.DataFrame([row(result) for result in results])
    table.to_csv(FOLDER / f"{name}.csv", index=False)
    published = pd.DataFrame([in_short(result) for result in results])
    published.to_csv(FOLDER / f"{name}_short.csv", index=False, float_format="%.4g")
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


def is_known(case: Case) -> bool:
    """Whether t2l has all that a case hides, and it hides something."""
    # here, so that listing cases does not import the simulator in the parent
    from t2l.effects.registry import builtin

    names = {snake(type(effect).__name__) for effect in case.hidden}
    return bool(names) and names <= set(builtin())


def judged(case: Case, only_true: bool = False, limit_s: float = LIMIT_S) -> dict:
    """A case's result, from its file or made now; why it `failed` where nothing was recorded."""
    path = FOLDER / ("results_only_true" if only_true else "results") / f"{case.name}.json"
    key = code_key()
    if path.exists():
        kept = json.loads(path.read_text())
        same = kept["key"] == key and kept["truth"] == json.loads(json.dumps(case.truth()))
        # one that was stopped may end within a longer limit
        if same and (not kept["stopped"] or kept["limit_s"] >= limit_s):
            return kept
    try:
        write_case(case, FOLDER / "cases")
    except FloatingPointError as error:  # the robot ran out of control
        return {"case": case.name, "failed": str(error)}
    found = explained(FOLDER / "cases" / case.name, only_true, limit_s)
    result = {"key": key, "truth": case.truth(), "limit_s": limit_s, **found}
    write_text(json.dumps(result, indent=1), path)
    return json.loads(path.read_text())


def code_key() -> str:
    """A digest of the code that the table judges."""
    digest = hashlib.sha256()
    for package in EXPLAINS:
        for file in sorted((ROOT / "src/t2l" / package).rglob("*.py")):
            digest.update(file.read_bytes())
    return digest.hexdigest()[:16]


def explained(folder: Path, only_true: bool = False, limit_s: float = LIMIT_S) -> dict:
    """Explain the recordings of `folder` as `t2l explain` does; errors in rad.

    Args:
        only_true: t2l knows no effect but the hidden ones.
        limit_s: of a core, after which it ends with the best so far.
    """
    # here, so that listing cases does not import the simulator in the parent
    from t2l.detective import explanation
    from t2l.detective.data_split import split
    from t2l.diagnose.recordings_and_model import read_recordings_and_model
    from t2l.effects.law import TENDON
    from t2l.identify.step_size import substeps_for

    began = process_time()
    told: list[float] = []
    truth = yaml.safe_load((folder / "truth.yaml").read_text())
    train, held = [folder / "train"], [folder / "holdout"]
    model, recordings, holdout = read_recordings_and_model(train, held)
    if only_true:
        true = {snake(entry["effect"]) for entry in truth["hidden"]}
        model = replace(model, without=tuple(sorted(set(model.known_effects()) - true)))
    substeps = substeps_for(model, recordings)
    data = split(model.robot, recordings, holdout, substeps, threads=1)
    found = explanation.explained(
        model, data,
        tell=lambda what: told.append(process_time() - began),
        spent=lambda: (process_time() - began) / limit_s,
    )  # fmt: skip
    seconds = process_time() - began
    adopted = [name for step in found.steps for name in step.effects]
    shares = [share for step in found.steps for share in step.chosen_shares]
    hidden = {snake(entry["effect"]): entry for entry in truth["hidden"]}
    unknown = [name for name in hidden if name not in model.known_effects()]
    laws = [curve.law for curve in found.model.learned]
    return {
        "case": folder.name,
        "robot": truth["robot"],
        "hidden": list(hidden),
        "unknown": unknown,
        "unknown_on": joints_of([hidden[name] for name in unknown], data.fitted.joints),
        "known": not unknown,
        "hardly_seen": hardly_seen(folder),
        "verdict": "missing_effect" if adopted else found.verdict,
        "first": adopted[0] if adopted else None,
        "adopted": adopted,
        "chosen": [share for share in shares if share is not None],
        "final_verdict": found.verdict,
        "before": found.steps[0].test_rmse_rad,
        "after": found.steps[-1].test_rmse_rad,
        "stand": list(found.model.effects),
        "curves": [law.name for law in laws],
        # a tendon pulls on both
        "curves_on": [[law.joint, law.of] if law.kind == TENDON else [law.joint] for law in laws],
        "noise_floor": found.noise_floor_rad,
        "recovered": recovered(truth["hidden"], found.model),
        "seconds": seconds,
        "first_answer_s": min(told, default=None),
        "stopped": found.stopped_after_s is not None,
    }


def hardly_seen(folder: Path) -> list[str]:
    """Hidden effects that move no joint of the training recordings by `VISIBLE` times the noise."""
    path = folder / "visibility.csv"
    if not path.exists():
        return []
    table = pd.read_csv(path)
    return [snake(name) for name in table["effect"][table["ratio"] < VISIBLE]]


def joints_of(hidden: Sequence[dict], joints: Sequence[str]) -> list[str]:
    """Joints that these effects act on: those that they give numbers to, or else all."""
    on: set[str] = set()
    for entry in hidden:
        each = [value for value in entry.values() if isinstance(value, dict)]
        given = {joint for value in each for joint, number in value.items() if number}
        on |= given or set(joints)
    return [joint for joint in joints if joint in on]


def recovered(hidden: list[dict], model) -> dict[str, float]:
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
    """CommandDelay → command_delay; or what else t2l calls it."""
    return CALLED.get(name) or re.sub(r"(?<!^)(?=[A-Z])", "_", name).lower()


def with_names(result: dict) -> list[str]:
    """Hidden effects that t2l knows."""
    return [name for name in result["hidden"] if name not in result["unknown"]]


def wrong_names(result: dict) -> list[str]:
    """Known effects of the final model that are not hidden."""
    return [name for name in result["stand"] if name not in result["hidden"]]


def right_curves(result: dict) -> bool:
    """Whether there are curves, all on joints that have a hidden effect without a name."""
    on = set(result["unknown_on"])
    return bool(result["curves"]) and all(on.issuperset(joints) for joints in result["curves_on"])


def right(result: dict) -> bool:
    """Every known effect by its name, a curve for one that has none, and nothing else."""
    curves = right_curves(result) if result["unknown"] else not result["curves"]
    return curves and set(result["stand"]) == set(with_names(result))


def summary(results: Sequence[dict]) -> pd.DataFrame:
    """What is asked of an explanation, and in how many of n the answer is yes."""
    known = [r for r in results if r["hidden"] and not r["unknown"]]
    clean = [r for r in results if not r["hidden"]]
    unknown = [r for r in results if r["unknown"]]
    beside = [r for r in unknown if with_names(r)]
    seconds = [r["seconds"] for r in results]

    def seen(result: dict) -> set[str]:
        return set(result["hidden"]) - set(result["hardly_seen"])

    counted = {
        "known effects named": [n in r["stand"] for r in known for n in r["hidden"]],
        "… of those that show": [n in r["stand"] for r in known for n in seen(r)],
    }
    for what, (least, most) in AT_ONCE.items():
        some = [r for r in known if least <= len(r["hidden"]) <= most]
        counted |= {
            f"{what}: named": [set(r["hidden"]) <= set(r["stand"]) for r in some],
            f"{what}: named, as far as they show": [seen(r) <= set(r["stand"]) for r in some],
            f"{what}: named, and nothing else": [right(r) for r in some],
        }
    counted |= {
        "known effects: error at most 1.2 times the noise": [
            r["after"] <= NEAR * r["noise_floor"] for r in known
        ],
        "nothing hidden, yet something adopted": [bool(r["stand"] or r["curves"]) for r in clean],
        "unknown effect: a wrong name beside": [bool(wrong_names(r)) for r in unknown],
        "unknown effect: curves, all on its joints": [right_curves(r) for r in unknown],
        "unknown effect: error at most twice the noise": [
            r["after"] <= TWICE * r["noise_floor"] for r in unknown
        ],
        "known effect beside an unknown one: it is named": [
            n in r["stand"] for r in beside for n in with_names(r)
        ],
        "… a wrong name is adopted too": [bool(wrong_names(r)) for r in beside],
        "test error larger by more than 2 %": [r["after"] > WORSE * r["before"] for r in results],
        "stopped": [r["stopped"] for r in results],
    }
    rows = [(what, f"{sum(those)}", len(those)) for what, those in counted.items() if those]
    if seconds:
        times = f"{np.median(seconds):.0f} and {max(seconds):.0f}"
        rows.append(("seconds, median and longest", times, len(seconds)))
    first = [r["first_answer_s"] for r in results if r["first_answer_s"] is not None]
    if first:
        rows.append(("… to the first answer, median", f"{np.median(first):.0f}", len(first)))
    return pd.DataFrame(rows, columns=["what", "found", "n"])


def in_short(result: dict) -> dict:
    """What docs/data has of a case; errors in mrad."""
    first = result["first_answer_s"]
    return {
        "case": result["case"],
        "hidden": " ".join(result["hidden"]),
        "names": " ".join(sorted(result["stand"])),
        "curves": " ".join(result["curves"]),
        "verdict": result["final_verdict"],
        "noise": 1e3 * result["noise_floor"],
        "before": 1e3 * result["before"],
        "after": 1e3 * result["after"],
        "first_answer_s": "" if first is None else round(first),
        "seconds": round(result["seconds"]),
        "stopped": int(result["stopped"]),
    }


def row(result: dict) -> dict:
    """What the table shows: names and curves of the final model, errors in mrad.

    `named` are known effects that are not hidden.
    """

    def mrad(value: float) -> str:
        return f"{1e3 * value:.3f}"

    worst = max(result["recovered"].values(), default=np.nan)
    return {
        "case": result["case"],
        "hidden": _listed(result["hidden"]),
        "right": "yes" if right(result) else "NO",
        "adopted": _listed(result["stand"]),
        "named": " + ".join(wrong_names(result)),
        "curves": " + ".join(result["curves"]),
        "in the end": result["final_verdict"],
        "chosen in": ", ".join(f"{share:.0%}" for share in result["chosen"]),
        "before": mrad(result["before"]),
        "test error after": mrad(result["after"]),
        "seconds": f"{result['seconds']:.0f}",
        "noise": mrad(result["noise_floor"]),
        "parameter off by": "" if np.isnan(worst) else f"{worst:.1%}",
    }


def _listed(names: Sequence[str]) -> str:
    return " + ".join(names) or "nothing"
