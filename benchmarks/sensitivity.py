"""What halving and doubling a constant does to the answers on a few development cases.

A job explains one case with one constant changed, in an interpreter of its own: the constant is
changed where its module is compiled, so that all that is made of it changes too. Each result is a
file in the folder that `--out` names, and what is there is not done again.
"""

import argparse
import ast
import importlib.abc
import importlib.machinery
import json
import os
import subprocess
import sys
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from pathlib import Path

import pandas as pd

# not from benchmarks.scene, which imports modules that are to be changed first
ROOT = Path(__file__).parents[1]
FOLDER = ROOT / "results/bench/constants"
# one or two joints, most within a minute: clean, a friction, two at once, play of a rough loss,
# a delay, and torques that no known effect gives
CASES = (
    "clean_pendulum",
    "coulomb_friction_1_pendulum",
    "pair_1_pendulum",
    "backlash_1_pendulum",
    "command_delay_3_two_joint_arm",
    "odd_position_torque_1_pendulum",
)
FACTORS = (0.5, 2.0)
TIME_LIMIT_S = 600
WRITTEN_EVERY = 30  # jobs: what is done is seen, and stays where the machine goes
# answers that are compared with those of the constants as they are
ANSWERS = ("verdict", "first", "adopted", "final_verdict", "curves")
UNCHANGED = ("", "", 1.0)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Of the command line."""
    parser.add_argument("--processes", type=int, default=1, metavar="N", help="jobs at once")
    parser.add_argument("--out", type=Path, default=FOLDER, metavar="FOLDER", help="of the results")
    parser.add_argument(
        "--cases", nargs="+", default=CASES, metavar="CASE", help="of benchmarks.hidden_effects"
    )
    parser.add_argument(
        "--kinds", nargs="+", default=("tuned",), metavar="KIND", help="of the constants"
    )


def run(
    constants: Sequence[tuple[str, str, str]],
    out: Path,
    processes: int,
    cases: Sequence[str] = CASES,
) -> pd.DataFrame:
    """One row a constant, after all jobs that are not done yet.

    Args:
        constants: module, name and value as it is written.
    """
    _write_cases(cases, out)
    todo = [job for job in jobs(constants, cases) if not _file(out, *job).exists()]
    with ThreadPoolExecutor(processes) as pool:
        running = [pool.submit(_start, out, job) for job in todo]
        for number, done in enumerate(as_completed(running), 1):
            print(f"{number} of {len(todo)}: {done.result()}", flush=True)
            if number % WRITTEN_EVERY == 0:
                write_tables(constants, out, cases)
    return write_tables(constants, out, cases)


def write_tables(
    constants: Sequence[tuple[str, str, str]], out: Path, cases: Sequence[str]
) -> pd.DataFrame:
    """results.csv, a row a job that is done; and table.csv and table.md, a row a constant."""
    results = rows(constants, out, cases)
    results.to_csv(out / "results.csv", index=False)
    table = told(results) if len(results) else results
    table.to_csv(out / "table.csv", index=False)
    (out / "table.md").write_text(table.to_markdown(index=False) + "\n")
    return table


def jobs(
    constants: Sequence[tuple[str, str, str]], cases: Sequence[str]
) -> Iterator[tuple[str, str, float, str]]:
    """Module, name, factor and case of each; first those of the constants as they are."""
    for case in cases:
        yield (*UNCHANGED, case)
    for module, name, value in constants:
        for factor in FACTORS:
            if changed(value, factor) != changed(value, 1.0):
                for case in cases:
                    yield module, name, factor, case


def changed(source: str, factor: float) -> str:
    """An expression with each of its numbers times a factor; whole ones stay so."""
    return ast.unparse(_scaled(ast.parse(source, mode="eval"), factor))


def _scaled(tree: ast.AST, factor: float) -> ast.AST:
    for node in ast.walk(tree):
        if isinstance(node, ast.Constant) and type(node.value) in (int, float):
            value = factor * node.value
            # half of one is none, which is no value of a count
            node.value = max(1, int(value)) if isinstance(node.value, int) else value
    return tree


class Changed(importlib.abc.MetaPathFinder):
    """Finds one module, and compiles it with one constant changed."""

    def __init__(self, module: str, name: str, factor: float):
        self.module, self.name, self.factor = module, name, factor

    def find_spec(self, fullname, path, target=None):
        if fullname != self.module:
            return None
        spec = importlib.machinery.PathFinder.find_spec(fullname, path)
        spec.loader = _Loader(fullname, spec.origin, self)
        return spec


class _Loader(importlib.machinery.SourceFileLoader):
    def __init__(self, fullname: str, path: str, wanted: Changed):
        super().__init__(fullname, path)
        self.wanted = wanted

    def get_code(self, fullname):
        # not from the cache of compiled modules
        tree = ast.parse(Path(self.path).read_text())
        for node in tree.body:
            names = [ast.unparse(t) for t in getattr(node, "targets", [])]
            if self.wanted.name in [name.strip("()") for name in names]:
                _scaled(node.value, self.wanted.factor)
                return compile(tree, self.path, "exec")
        raise AttributeError(f"{fullname} has no constant {self.wanted.name}")


def explain(module: str, name: str, factor: float, case: str, out: Path) -> None:
    """Explain a case with a constant changed, and write what came out."""
    if module in sys.modules:
        raise ImportError(f"{module} was imported before its constant could be changed")
    sys.meta_path.insert(0, Changed(module, name, factor))
    from benchmarks import hidden

    try:
        result = hidden.explained(out / "cases" / case)
    except Exception as error:
        # a constant without which nothing works is a result too
        result = {"error": f"{type(error).__name__}: {error}"}
    _write(result, _file(out, module, name, factor, case))


def rows(
    constants: Sequence[tuple[str, str, str]], out: Path, cases: Sequence[str]
) -> pd.DataFrame:
    """One row a job that is done: its answers, and whether they are those without the change."""
    found = []
    for module, name, factor, case in jobs(constants, cases):
        path, as_is = _file(out, module, name, factor, case), _file(out, *UNCHANGED, case)
        if not (path.exists() and as_is.exists()):
            continue
        result, before = json.loads(path.read_text()), json.loads(as_is.read_text())
        row = {"constant": f"{module.removeprefix('t2l.')}.{name}", "factor": factor, "case": case}
        row |= {key: _words(result.get(key)) for key in ANSWERS}
        row["same answer"] = all(result.get(key) == before.get(key) for key in ANSWERS)
        row["error ratio"] = result.get("after", float("nan")) / before["after"]
        row["time ratio"] = result.get("seconds", float("nan")) / before["seconds"]
        row["failed"] = result.get("error", "")
        found.append(row)
    return pd.DataFrame(found)


def told(results: pd.DataFrame) -> pd.DataFrame:
    """One row a constant: in how many cases its halving or doubling changes an answer."""
    table = []
    for constant, group in results[results["constant"] != "."].groupby("constant", sort=False):
        row = {"constant": constant}
        for factor, word in zip(FACTORS, ("halved", "doubled"), strict=True):
            of = group[group["factor"] == factor]
            other = of[~of["same answer"]]
            row[f"{word}: answers changed"] = f"{len(other)} of {len(of)}" if len(of) else "-"
            row[f"{word}: in"] = ", ".join(other["case"])
            row[f"{word}: error"] = _range(of["error ratio"])
            row[f"{word}: time"] = f"{of['time ratio'].mean():.2f}" if len(of) else "-"
        table.append(row)
    return pd.DataFrame(table)


def _range(ratios: pd.Series) -> str:
    return f"{ratios.min():.2f} to {ratios.max():.2f}" if len(ratios) else "-"


def _words(value: object) -> str:
    return ", ".join(map(str, value)) if isinstance(value, list) else str(value)


def _file(out: Path, module: str, name: str, factor: float, case: str) -> Path:
    label = f"{module.removeprefix('t2l.')}.{name}_{factor:g}".replace(", ", "+")
    return out / "jobs" / label / f"{case}.json"


def _write(result: dict, path: Path) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    part = path.with_suffix(f".{os.getpid()}.part")
    part.write_text(json.dumps(result, indent=1))
    part.replace(path)


def _write_cases(names: Sequence[str], out: Path) -> None:
    from benchmarks.hidden_effects.__main__ import write_case
    from benchmarks.hidden_effects.cases import cases

    table = {case.name: case for case in cases()}
    if unknown := set(names) - set(table):
        raise SystemExit(f"no case {', '.join(sorted(unknown))}")
    for name in names:
        write_case(table[name], out / "cases")


def _start(out: Path, job: tuple[str, str, float, str]) -> str:
    """Run a job in an interpreter of its own with one thread; how it ended, in words."""
    module, name, factor, case = job
    command = [
        sys.executable, "-m", "benchmarks.sensitivity", module, name, str(factor), case, str(out),
    ]  # fmt: skip
    one_thread = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"), "1")
    what = f"{module}.{name} × {factor:g}, {case}"
    try:
        ended = subprocess.run(
            command, cwd=ROOT, env={**os.environ, **one_thread}, timeout=TIME_LIMIT_S,
            capture_output=True, text=True,
        )  # fmt: skip
    except subprocess.TimeoutExpired:
        _write({"error": f"took longer than {TIME_LIMIT_S} s"}, _file(out, *job))
        return f"{what}: too long"
    return what if ended.returncode == 0 else f"{what}: {ended.stderr[-500:]}"


if __name__ == "__main__":
    explain(sys.argv[1], sys.argv[2], float(sys.argv[3]), sys.argv[4], Path(sys.argv[5]))
