"""The tuned constants of the search are few, listed, and each has its reason."""

import ast
import re
from pathlib import Path

import pytest

from t2l.diagnose import settings
from t2l.identify import block_bootstrap, rough

SOURCE = Path(settings.__file__)
FOLDER = SOURCE.parent
# what searches and decides; the others describe an error, or write
SEARCH = (
    "backward_elimination", "candidate", "evidence", "final_fit", "forward_selection",
    "idle_joints", "joint_growth", "joint_start", "multi_fidelity", "racing", "ranking",
    "stability_selection", "starting_points",
)  # fmt: skip
# of the fits that the search runs
FITS = (block_bootstrap.__file__, rough.__file__)
NUMERICS = {"SEED", "RIDGE", "LEAST_SIZE"}  # no result of interest moves with them
MOST = 30


def constants(path: Path) -> dict[str, int]:
    """Names of a module's numbers in capitals, and how many numbers each holds."""
    found = {}
    for node in ast.parse(path.read_text()).body:
        if isinstance(node, ast.Assign) and isinstance(node.targets[0], ast.Name):
            numbers = [
                n for n in ast.walk(node.value)
                if isinstance(n, ast.Constant) and isinstance(n.value, int | float)
            ]  # fmt: skip
            if node.targets[0].id.isupper() and numbers:
                found[node.targets[0].id] = len(numbers)
    return found


def test_there_are_few():
    counted = constants(SOURCE)
    for path in FITS:
        counted |= {f"{Path(path).stem}.{k}": n for k, n in constants(Path(path)).items()}
    counted = {k: n for k, n in counted.items() if k.split(".")[-1] not in NUMERICS}
    assert sum(counted.values()) <= MOST, counted


@pytest.mark.parametrize("path", [SOURCE, *map(Path, FITS)], ids=lambda p: p.stem)
def test_each_has_its_reason(path):
    lines = path.read_text().splitlines()
    for name in constants(path).keys() - NUMERICS:
        (line,) = [line for line in lines if re.match(rf"{name} = ", line)]
        assert re.search(r"  # \w.{10}", line), line


@pytest.mark.parametrize("module", SEARCH)
def test_the_search_has_none_elsewhere(module):
    assert constants(FOLDER / f"{module}.py").keys() <= NUMERICS
