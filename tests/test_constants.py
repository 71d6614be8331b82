"""Every tuned constant of the detective says why it has its value."""

import ast
from pathlib import Path

import pytest

import t2l

SOURCE = Path(t2l.__file__).parent
PACKAGES = ("diagnose", "identify", "propose")


def constants(path: Path) -> list[tuple[str, bool]]:
    """Name of each number at the head of a module, and whether a comment stands beside it."""
    source = path.read_text()
    lines, found = source.splitlines(), []
    for node in ast.parse(source).body:
        if not isinstance(node, ast.Assign):
            continue
        names = [n.id for n in ast.walk(node.targets[0]) if isinstance(n, ast.Name)]
        values = [n.value for n in ast.walk(node.value) if isinstance(n, ast.Constant)]
        if values and all(n.isupper() for n in names) and all(_number(v) for v in values):
            line, above = lines[node.lineno - 1], lines[node.lineno - 2]
            found.append((", ".join(names), "#" in line or above.startswith("#")))
    return found


def _number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


@pytest.mark.parametrize("package", PACKAGES)
def test_every_constant_has_its_reason(package):
    paths = sorted((SOURCE / package).rglob("*.py"))
    found = {f"{path.name}: {name}": said for path in paths for name, said in constants(path)}
    assert len(found) > 10, "no constants were found: the test looks in the wrong place"
    assert [name for name, said in found.items() if not said] == []


def test_a_constant_without_a_reason_is_found(tmp_path):
    path = tmp_path / "module.py"
    path.write_text('"""Doc."""\n\nLEVEL = 0.05\nMOST = 3  # as many as fit\nNAME = "x"\n')
    assert constants(path) == [("LEVEL", False), ("MOST", True)]
