"""The numbers that a diagnosis depends on: how many, of which kind, why, and what moving one does.

`python -m benchmarks constants` reads the source. A number is any literal of the packages below;
the comment beside it, or above, begins with its kind and goes on with its reason. Where a place
says what a number is, no comment needs to: see `by_place`.

`python -m benchmarks constants --sensitivity` halves and doubles each tuned one, see
`benchmarks.sensitivity`.
"""

import argparse
import ast
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import pandas as pd

from benchmarks import sensitivity
from benchmarks.scene import ROOT

SOURCE = ROOT / "src/t2l"
PACKAGES = (
    "diagnose",
    "identify",
    "propose",
    "detective",
    "effects",
    "design",
    "drift",
    "recordings",
)
KINDS = {
    "tuned": "a choice that may change an answer",
    "derived": "made of other constants",
    "statistics": "a convention: a level, how often is drawn",
    "bound": "what is possible or plausible: the range of a search, input that is accepted",
    "guess": "where a fit begins; of several the best is taken",
    "numerics": "a tolerance, a step, the size of a block: changes time, not answers",
    "format": "a unit, a definition, words",
}
TAG = re.compile(rf"^({'|'.join(KINDS)}): (.+)$", re.DOTALL)
# what counts, halves, squares and writes numbers is no choice; what is less keeps from zero
PLAIN, TINY = (0, 1, 2, 3, 4, 5, 0.5, 10, 100, 1e3), 1e-6
# whose arguments are words or digits
SAYING = ("progress", "round", "Field", "lru_cache")


@dataclass(frozen=True)
class Constant:
    """One number, or one line of them.

    Attributes:
        name: of the constant; of a number inside a function, the function's.
        place: file and line.
        value: as it is written.
        kind: one of `KINDS`, or None where nothing says it.
        named: whether it stands at the head of a module, where it can be changed.
    """

    name: str
    place: str
    value: str
    kind: str | None
    reason: str
    named: bool


def main(arguments: Sequence[str]) -> pd.DataFrame:
    """What the command line asks for."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks constants", description=__doc__)
    parser.add_argument("--sensitivity", action="store_true", help="halve and double each")
    sensitivity.add_arguments(parser)
    given = parser.parse_args(arguments)
    if not given.sensitivity:
        return run()
    # what plans motions changes no explanation
    judging = [c for c in census() if not c.place.startswith("design/")]
    chosen = [c for c in judging if c.kind in given.kinds and c.named]
    modules = [(module_of(c), c.name, c.value) for c in chosen]
    return sensitivity.run(modules, given.out, given.processes, given.cases)


def run() -> pd.DataFrame:
    """One row a constant, by kind; how many of each kind is printed above."""
    found = census()
    print(counts(found).to_markdown(index=False) + "\n")
    rows = [
        {
            "kind": c.kind or "NONE", "constant": c.name, "value": c.value, "reason": c.reason,
            "place": c.place,
        }
        for c in sorted(found, key=lambda c: [*KINDS, None].index(c.kind))
    ]  # fmt: skip
    return pd.DataFrame(rows)


def counts(found: Sequence[Constant]) -> pd.DataFrame:
    """How many constants of each kind, at the head of modules, inside functions, and in all."""
    rows = []
    for kind, meaning in KINDS.items():
        of_kind = [c for c in found if c.kind == kind]
        named = sum(c.named for c in of_kind)
        inside = len(of_kind) - named
        rows.append(
            {"kind": kind, "meaning": meaning, "named": named, "inside functions": inside,
             "all": len(of_kind)}
        )  # fmt: skip
    return pd.DataFrame(rows)


def census(source: Path = SOURCE, packages: Sequence[str] = PACKAGES) -> list[Constant]:
    """Every constant of some packages."""
    paths = [path for package in packages for path in sorted((source / package).rglob("*.py"))]
    return [constant for path in paths for constant in constants(path, source)]


def module_of(constant: Constant) -> str:
    """The name to import by of the module that holds it."""
    file = constant.place.split(":")[0].removesuffix(".py")
    return ".".join(("t2l", *Path(file).parts))


def constants(path: Path, source: Path) -> Iterator[Constant]:
    """Those of one module, in their order."""
    text = path.read_text()
    lines, tree = text.splitlines(), ast.parse(text)
    for node in tree.body:
        head = isinstance(node, ast.Assign) and all(map(str.isupper, _targets(node)))
        places, seen = by_place(path, source), set()
        for number, name, kind in _numbers(node, "", places, head):
            line = node.lineno if head else number.lineno
            if line in seen:
                continue
            seen.add(line)
            told, reason = _told(lines, line, node.end_lineno if head else line)
            shown = (
                ast.get_source_segment(text, node.value)
                if head
                else lines[line - 1].partition("  # ")[0]
            )
            place = f"{path.relative_to(source).as_posix()}:{line}"
            label = ", ".join(_targets(node)) if head else name
            yield Constant(label, place, " ".join(shown.split()), told or kind, reason, named=head)


def by_place(path: Path, source: Path) -> dict[str, str]:
    """Kinds of numbers by where they stand: arguments of these calls, and in these functions.

    An effect's file states its parameters' ranges, and where a fit of it begins.
    """
    if path.relative_to(source).parts[0] != "effects":
        return {"Parameter": "bound"}
    return {"Parameter": "bound", "starts": "guess", "order": "format"}


def _numbers(
    node: ast.AST, name: str, places: dict[str, str], every: bool, kind: str | None = None
) -> Iterator[tuple[ast.Constant, str, str | None]]:
    """Numbers in a node, the function's name, and the kind that a place gives.

    Args:
        every: not only those that are a choice.
    """
    if isinstance(node, ast.Constant):
        if _is_number(node.value) and (every or _is_choice(node.value)):
            yield node, name, kind
        return
    if isinstance(node, ast.JoinedStr):
        return
    if isinstance(node, ast.Call):
        called = (
            node.func.attr if isinstance(node.func, ast.Attribute) else getattr(node.func, "id", "")
        )
        if called in SAYING:
            return
        kind = places.get(called, kind)
    if isinstance(node, ast.FunctionDef | ast.ClassDef):
        name, kind = node.name, places.get(node.name, kind)
    if isinstance(node, ast.Assign):
        kind = next((places[t] for t in _targets(node) if t in places), kind)
    for child in ast.iter_child_nodes(node):
        yield from _numbers(child, name, places, every, kind)


def _is_number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def _is_choice(value: float) -> bool:
    return value not in PLAIN and abs(value) > TINY


def _targets(node: ast.AST) -> list[str]:
    targets = node.targets if isinstance(node, ast.Assign) else [node.target]
    return [n.id for target in targets for n in ast.walk(target) if isinstance(n, ast.Name)]


def _told(lines: Sequence[str], first: int, last: int) -> tuple[str | None, str]:
    """Kind and reason in the comment on one of the lines, or in those right above."""
    beside = [line.partition("  # ")[2] for line in lines[first - 1 : last]]
    above: list[str] = []
    for line in reversed(lines[: first - 1]):
        if not line.strip().startswith("# ") or line.startswith("# --"):
            break
        above.insert(0, line.strip()[2:])
    for comment in (*beside, " ".join(above)):
        if found := TAG.match(comment):
            return found[1], found[2]
    return None, next(filter(None, (*beside, " ".join(above))), "")
