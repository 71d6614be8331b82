"""What models of real machines lack, and the errors that are left.

`python -m benchmarks machines --data FOLDER [--leave-outs N] [NAME …]`. A machine is a folder with
recordings in `train/` and `holdout/`, or with recordings alone, a part of which is then held out;
FOLDER is one or holds several. docs/data/machines.csv gets a row a machine and docs/machines.md its
table; rows of other machines stay. What is made is kept in results/bench/machines until the code or
the recordings change, so that an interrupted run goes on where it stopped.
"""

import argparse
import hashlib
import json
import os
import re
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from time import perf_counter

import numpy as np
import pandas as pd
import yaml

from benchmarks import one_core, servo
from benchmarks.hidden import code_key
from benchmarks.scene import ROOT
from t2l.artefacts import write_text

FOLDER = ROOT / "results/bench/machines"
MAKERS = ROOT / "benchmarks/machines.yaml"
DOCS = ROOT / "docs"
TABLE, PAGE = "data/machines.csv", "machines.md"
PROCESSES = min(2, len(os.sched_getaffinity(0)))
MOST_LEAVE_OUTS = 10
LIMIT_S = 600
PIECES, HELD_PIECES = 8, 2  # of each of fewer than three recordings
BEGIN, END = "<!-- table: python -m benchmarks machines -->", "<!-- end of table -->"
# recordings in the makers' own format: what makes `fit` and `test` of them
IMPORTED = {"xl330_pendulum": servo.imported}


@dataclass(frozen=True)
class Machine:
    """Folders or files of recordings to explain, and to report the error of, if they are given."""

    name: str
    train: Path
    holdout: Path | None


def main(arguments: Sequence[str]) -> pd.DataFrame:
    """What the command line asks for."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks machines", description=__doc__)
    parser.add_argument("names", nargs="*", metavar="NAME", help="machines (default: all there)")
    folder = "a machine's folder, or one that holds several; may be repeated"
    parser.add_argument("--data", action="append", type=Path, required=True, help=folder)
    others = "choices of what is held out, for how often the leading effects are the same"
    parser.add_argument(
        "--leave-outs", type=int, default=0, choices=range(MOST_LEAVE_OUTS + 1),
        metavar="N", help=others,
    )  # fmt: skip
    longest = "the longest search; one that takes longer ends with the best so far"
    parser.add_argument("--limit", type=float, default=LIMIT_S, metavar="S", help=longest)
    parser.add_argument("--out", type=Path, default=DOCS, help="where table and page are")
    one_core.add_processes(parser, PROCESSES)
    given = parser.parse_args(arguments)
    if not given.limit > 0:
        parser.error(f"--limit: found {given.limit:g}; allowed: above 0 s")
    machines = chosen(given.data, given.names)
    return run(machines, given.leave_outs, given.limit, given.out, given.processes)


def run(
    machines: Sequence[Machine],
    leave_outs: int = 0,
    limit_s: float = LIMIT_S,
    out: Path = DOCS,
    processes: int = PROCESSES,
) -> pd.DataFrame:
    """The table, one row a machine; it is written after each that ends."""
    items = [(machine, None) for machine in machines]
    items += [(machine, seed) for machine in machines for seed in range(leave_outs)]
    done: dict[str, list[dict]] = {machine.name: [] for machine in machines}
    judge = partial(judged, limit_s=limit_s)
    for (machine, seed), result in zip(items, one_core.each(judge, items, processes), strict=True):
        done[machine.name].append(result)
        print(f"{machine.name}, {_choice(seed)}: {result['lacks']}", flush=True)
        write(out, [row(name, results) for name, results in done.items() if results])
    return read_table(out)


def chosen(folders: Sequence[Path], names: Sequence[str]) -> list[Machine]:
    """The machines in `folders`, or those of `names`."""
    found = {}
    for folder in folders:
        if not folder.is_dir():
            raise SystemExit(f"--data: found no folder {folder}")
        inside = [folder] if _is_machine(folder) else filter(_is_machine, folder.iterdir())
        here = {path.name: path for path in (one.resolve() for one in inside)}
        if not here:
            raise SystemExit(
                f"--data: found no machine in {folder}; allowed: recordings, or train/ with some, "
                "in it or in its folders"
            )
        found |= here
    unknown = sorted(set(names) - set(found))
    if unknown:
        raise SystemExit(f"no machine {', '.join(unknown)}; there are {', '.join(sorted(found))}")
    # recordings in the makers' format are imported only if they are asked for
    return [_machine(found[name]) for name in sorted(names or found)]


def _is_machine(folder: Path) -> bool:
    train = folder / "train"
    return any((train if train.is_dir() else folder).glob("[!.]*.csv"))


def _machine(folder: Path) -> Machine:
    train, holdout = folder / "train", folder / "holdout"
    if folder.name in IMPORTED:
        home = IMPORTED[folder.name](folder)
        train, holdout = home / "fit", home / "test"
    if not train.is_dir():
        return Machine(folder.name, folder, None)
    return Machine(folder.name, train, holdout if holdout.is_dir() else None)


def judged(item: tuple[Machine, int | None], limit_s: float) -> dict:
    """A machine's result for one choice of what is held out, from its file or made now."""
    machine, seed = item
    path = FOLDER / machine.name / f"{_choice(seed)}.json"
    key = _key(machine)
    if path.exists():
        kept = json.loads(path.read_text())
        # one that was stopped may end within a longer limit
        if kept["key"] == key and (not kept["stopped"] or kept["limit_s"] >= limit_s):
            return kept
    result = {"key": key, "limit_s": limit_s, **explained(machine, seed, limit_s)}
    write_text(json.dumps(result, indent=1), path)
    return json.loads(path.read_text())


def _choice(seed: int | None) -> str:
    return "as given" if seed is None else f"choice {seed}"


def _key(machine: Machine) -> str:
    """A digest of the code, the recordings and the makers' model."""
    from t2l.recordings.log import files, read_recordings
    from t2l.robots.plant import files as model_files

    folders = [folder for folder in (machine.train, machine.holdout) if folder]
    robot = read_recordings(machine.train)[0].robot
    read = [path for folder in folders for path in files(folder)] + list(model_files(robot))
    digest = hashlib.sha256(code_key().encode())
    digest.update(json.dumps(makers_effects(machine.name)).encode())
    for path in read:
        digest.update(Path(path).read_bytes())
    return digest.hexdigest()[:16]


def explained(machine: Machine, seed: int | None, limit_s: float) -> dict:
    """What the search finds; errors in rad, of what is held out unless named otherwise.

    Args:
        seed: of a random choice of what is held out; None for that of the machine's folder.
    """
    from t2l.detective import explanation
    from t2l.detective.data_split import split
    from t2l.diagnose.recordings_and_model import check_worth_fitting, read_recordings_and_model
    from t2l.diagnose.settings import FRACTION
    from t2l.identify.model import Model
    from t2l.identify.step_size import substeps_for
    from t2l.recordings.splits import LEAST_TO_HOLD_OUT_WHOLE, hold_out

    holdout = [machine.holdout] if machine.holdout else []
    model, recordings, held = read_recordings_and_model([machine.train], holdout)
    check_worth_fitting(model, recordings, held)
    every = [*recordings, *held]
    pieces = seed is not None and len(every) < LEAST_TO_HOLD_OUT_WHOLE
    if pieces:
        recordings, held = every, []
    elif seed is not None or (not held and len(every) >= LEAST_TO_HOLD_OUT_WHOLE):
        recordings, held = hold_out(every, FRACTION, seed or 0)
    began = perf_counter()
    data = split(model.robot, recordings, held, substeps_for(model, recordings), threads=1)
    if pieces:
        data = by_pieces(data, seed)
    joints = data.fitted.joints
    makers = makers_effects(machine.name)
    result = {
        "recordings": len(every),
        "held_out": len(held),
        "joints": len(joints),
        "before_training": rmse(model, data.fitted, data.fitted_mask),
        "before": rmse(model, data.test, data.test_mask),
        "makers": makers and rmse(Model(model.robot, makers), data.test, data.test_mask),
        "told": [],
    }
    found = explanation.explained(
        model, data, result["told"].append, spent=partial(_spent, began, limit_s)
    )
    return result | {
        "seconds": perf_counter() - began,
        "lacks": in_words(found.model, joints),
        "leading": sorted(found.steps[1].effects) if len(found.steps) > 1 else [],
        "effects": found.model.effects,
        "after_training": found.steps[-1].train_rmse_rad,
        "after": found.steps[-1].test_rmse_rad,
        "noise": found.noise_floor_rad,
        "verdict": found.verdict,
        "stopped": found.stopped_after_s is not None,
    }


def _spent(began: float, limit_s: float) -> float:
    return (perf_counter() - began) / limit_s


def by_pieces(data, seed: int):
    """Of each recording two of eight stretches of time, at random, report; the others are fitted.

    Each stretch that is fitted is a fold.
    """
    from t2l.seeds import generator

    samples, recordings = data.fitted.samples, data.fitted.recordings
    length = np.array([r.time[-1] - r.time[0] for r in recordings])[samples.recording]
    piece = np.minimum((samples.time / length * PIECES).astype(int), PIECES - 1)
    rng = generator(seed, "machines")
    held = np.zeros((len(recordings), PIECES), bool)
    for one in held:
        one[rng.choice(PIECES, HELD_PIECES, replace=False)] = True
    test = held[samples.recording, piece]
    stretch = (samples.recording * PIECES + piece)[~test]
    return replace(
        data, fitted_mask=~test, test=data.fitted, test_mask=test,
        folds=np.unique(stretch, return_inverse=True)[1][:, None],
    )  # fmt: skip


def rmse(model, predictor, mask: np.ndarray) -> float:
    """RMS error in rad of a model's positions where `mask` is set."""
    from t2l.identify.prediction import Request

    layout, u = model.vector(predictor.joints)
    q = predictor.predict([Request(layout, u[None])])[0][0]
    return float(np.sqrt(np.mean((q - predictor.samples.q)[mask] ** 2)))


def in_words(model, joints: Sequence[str]) -> str:
    """The adopted effects by their titles, with the joints where these are not all; and curves."""
    from t2l.names import listed

    words = []
    for term in replace(model, learned=()).terms(tuple(joints)):
        on = [joints[j] for j in term.joints]
        words.append(term.effect.title + ("" if len(on) == len(joints) else f" on {listed(on)}"))
    words += [curve.law.words for curve in model.learned]
    return listed(words) if words else "nothing"


def makers_effects(name: str) -> dict | None:
    """What a machine's makers identified beyond the model of its recordings, if they did."""
    return yaml.safe_load(MAKERS.read_text()).get(name)


def row(name: str, results: Sequence[dict]) -> dict[str, str]:
    """A row of the table: of the choice as given, and of the others how often they lead alike."""

    def mrad(value):
        return "" if value is None else f"{1e3 * value:.3g}"

    first, *others = results
    led = Counter(" + ".join(r["leading"]) or "nothing" for r in others)
    leading, times = led.most_common(1)[0] if led else ("", 0)
    return {
        "machine": name,
        "recordings": str(first["recordings"]),
        "held out": str(first["held_out"]),
        "joints": str(first["joints"]),
        "lacks": first["lacks"],
        "before [mrad]": mrad(first["before"]),
        "after [mrad]": mrad(first["after"]),
        "noise [mrad]": mrad(first["noise"]),
        "makers [mrad]": mrad(first["makers"]),
        "seconds": f"{first['seconds']:.0f}" + (", stopped" if first["stopped"] else ""),
        "leads most often": leading,
        "times": f"{times} of {led.total()}" if led else "",
    }


def read_table(out: Path = DOCS) -> pd.DataFrame:
    """The table as it was written, every cell a text."""
    return pd.read_csv(out / TABLE, dtype=str, keep_default_na=False)


def write(out: Path, rows: Sequence[dict[str, str]]) -> None:
    """Put rows into the table, and the table into the page."""
    table = pd.DataFrame(rows)
    if (out / TABLE).exists():
        old = read_table(out)
        table = pd.concat([old[~old["machine"].isin(table["machine"])], table])
    table = table.sort_values("machine")
    (out / TABLE).parent.mkdir(parents=True, exist_ok=True)
    write_text(table.to_csv(index=False), out / TABLE)
    page = out / PAGE
    if page.exists():
        write_text(with_table(page.read_text(), table), page)


def with_table(page: str, table: pd.DataFrame) -> str:
    """The page with this table between its marks."""
    parts = re.split(f"{re.escape(BEGIN)}.*?{re.escape(END)}", page, flags=re.S)
    if len(parts) != 2:
        raise SystemExit(f"{PAGE}: found {len(parts) - 1} tables; allowed: 1, as {BEGIN} … {END}")
    return f"{BEGIN}\n\n{shown(table)}\n\n{END}".join(parts)


def shown(table: pd.DataFrame) -> str:
    """The table as the page has it."""
    columns = {
        "machine": table["machine"],
        "recordings, of these held out": table["recordings"] + ", " + table["held out"],
        "joints": table["joints"],
        "lacks": table["lacks"],
        "error before, after": table["before [mrad]"] + " → " + table["after [mrad]"],
        "makers' model": table["makers [mrad]"],
        "noise": table["noise [mrad]"],
        "seconds": table["seconds"],
        "same effects lead": table["times"],
    }  # fmt: skip
    return pd.DataFrame(columns).to_markdown(index=False, disable_numparse=True)
