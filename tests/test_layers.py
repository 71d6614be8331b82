"""Imports go downwards only, as the README draws it."""

import ast
import subprocess
import sys
from collections import defaultdict
from graphlib import TopologicalSorter

import pytest

from tests.conftest import ROOT

LAYERS = [
    {"cli", "config", "figures", "report"},
    {"study"},
    {"plotting", "stats"},
    {"advise"},
    {
        *("bc", "design", "detective", "diagnose", "drift", "export", "propose"),
        *("response", "rl", "transfer"),
    },
    {"identify"},
    {"demos", "policies", "effects"},
    {"environment"},
    {"tasks"},
    {"actions"},
    {"hardware", "recordings"},
    {"robots"},
    {"gains", "sim"},
    {
        *("artefacts", "documents", "errors", "jobs", "names", "outputs", "registry"),
        *("seeds", "threads", "typed", "version", "waiting"),
    },
]
LEVEL = {name: level for level, names in enumerate(LAYERS) for name in names}
SOURCES = sorted((ROOT / "src/t2l").rglob("*.py"))


def package_of(path):
    return path.relative_to(ROOT / "src/t2l").parts[0].removesuffix(".py")


def imported(path):
    """Packages of t2l that a module imports, its own not."""
    parts = [module.split(".") for module in modules_imported(path)]
    return {p[1] for p in parts if p[0] == "t2l" and len(p) > 1} - {package_of(path)}


def parts_imported(path):
    """Parts of the study that a module imports."""
    parts = [module.split(".") for module in modules_imported(path)]
    return {p[2] for p in parts if p[:2] == ["t2l", "study"] and len(p) > 2}


def modules_imported(path):
    """Names as they stand: `from t2l.study import datasets` gives both of them."""
    found = []
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.ImportFrom):
            modules = [node.module or "", *(f"{node.module}.{name.name}" for name in node.names)]
        elif isinstance(node, ast.Import):
            modules = [alias.name for alias in node.names]
        else:
            continue
        found += modules
    return found


@pytest.mark.parametrize("path", SOURCES, ids=lambda p: str(p.relative_to(ROOT / "src")))
def test_imports_go_downwards(path):
    package = package_of(path)
    if package in ("__init__", "__main__"):
        return
    assert package in LEVEL, f"{package} has no layer"
    for other in imported(path):
        assert LEVEL[other] >= LEVEL[package], f"{package} imports {other}"


def test_no_packages_import_each_other_in_a_circle():
    graph = defaultdict(set)
    for path in SOURCES:
        graph[package_of(path)] |= imported(path)
    TopologicalSorter(graph).prepare()


def test_no_parts_of_the_study_import_each_other_in_a_circle():
    """A topic may use another's claims; the scoreboard, and what is kept, use all."""
    graph = defaultdict(set)
    for path in (ROOT / "src/t2l/study").rglob("*.py"):
        part = path.relative_to(ROOT / "src/t2l/study").parts[0].removesuffix(".py")
        graph[part] |= parts_imported(path) - {part}
    TopologicalSorter(graph).prepare()


@pytest.mark.parametrize("package", ["torch", "lerobot"])
def test_slow_libraries_stay_where_they_are_needed(package):
    """Importing lerobot takes seconds, torch two: only writing data sets, networks and GPUs may."""
    allowed = {"torch": {"policies", "rl", "sim/warp_batch.py"}, "lerobot": {"demos"}}[package]
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
            where = path.relative_to(ROOT / "src/t2l")
            assert {where.parts[0], str(where)} & allowed


@pytest.mark.parametrize("script", ["choose_scales", "deploy", "identify", "record_motion"])
def test_jobs_of_the_second_chain_that_do_not_train_do_without_torch(script):
    tree = ast.parse((ROOT / f"workflow/scripts/{script}.py").read_text())
    imports = [n for n in tree.body if isinstance(n, (ast.Import, ast.ImportFrom))]
    code = "\n".join(map(ast.unparse, imports)) + "\nimport sys; print('torch' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert done.stdout.strip() == "False", done.stderr


def test_reading_a_configuration_waits_for_no_statistics():
    """Every command of Snakemake reads one."""
    code = "import sys, t2l.config; print({'scipy.stats', 'statsmodels'} & set(sys.modules))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert done.stdout.strip() == "set()", done.stderr
