"""Imports go downwards only, as the README draws it."""

import ast
import subprocess
import sys

import pytest

from tests.conftest import ROOT

LAYERS = [
    {"cli", "config", "figures", "report", "stats"},
    {"bc", "diagnose", "rl", "transfer"},
    {"identify"},
    {"demos", "policies", "effects"},
    {"tasks"},
    {"actions"},
    {"hardware", "recordings"},
    {"robots"},
    {"gains", "sim"},
    {
        "artefacts",
        "registry",
        "documents",
        "errors",
        "jobs",
        "names",
        "outputs",
        "seeds",
        "typed",
        "version",
    },
]
LEVEL = {name: level for level, names in enumerate(LAYERS) for name in names}
SOURCES = sorted((ROOT / "src/t2l").rglob("*.py"))


@pytest.mark.parametrize("path", SOURCES, ids=lambda p: str(p.relative_to(ROOT / "src")))
def test_imports_go_downwards(path):
    package = path.relative_to(ROOT / "src/t2l").parts[0].removesuffix(".py")
    if package == "__init__":
        return
    assert package in LEVEL, f"{package} has no layer"
    for node in ast.walk(ast.parse(path.read_text())):
        modules = (
            [node.module or ""]
            if isinstance(node, ast.ImportFrom)
            else [alias.name for alias in node.names]
            if isinstance(node, ast.Import)
            else []
        )
        for module in modules:
            parts = module.split(".")
            if parts[0] == "t2l" and len(parts) > 1 and parts[1] != package:
                assert LEVEL[parts[1]] >= LEVEL[package], f"{package} imports {module}"


@pytest.mark.parametrize("package", ["torch", "lerobot"])
def test_slow_libraries_stay_where_they_are_needed(package):
    """Importing lerobot takes seconds, torch two: only writing data sets, and networks, may."""
    allowed = {"torch": {"policies", "rl"}, "lerobot": {"demos"}}[package]
    for path in SOURCES:
        tree = ast.parse(path.read_text())
        top = [n for n in tree.body if isinstance(n, (ast.Import, ast.ImportFrom))]
        names = {
            name.split(".")[0]
            for n in top
            for name in (
                [n.module or ""] if isinstance(n, ast.ImportFrom) else [a.name for a in n.names]
            )
        }
        if package in names:
            assert package != "lerobot", f"{path} imports lerobot at its top"
            assert path.relative_to(ROOT / "src/t2l").parts[0] in allowed


@pytest.mark.parametrize("script", ["choose_policy", "deploy", "identify", "record_motion"])
def test_jobs_of_the_second_chain_that_do_not_train_do_without_torch(script):
    tree = ast.parse((ROOT / f"workflow/scripts/{script}.py").read_text())
    imports = [n for n in tree.body if isinstance(n, (ast.Import, ast.ImportFrom))]
    code = "\n".join(map(ast.unparse, imports)) + "\nimport sys; print('torch' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert done.stdout.strip() == "False", done.stderr
