"""Configurations and tasks, from the bytes of their files to the checked study."""

import copy
import shutil
from pathlib import Path

import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st
from snakemake.exceptions import CliException

from snakemake_logger_plugin_t2l.configfiles import load
from t2l.config import read_study
from t2l.config.models import Configuration
from t2l.errors import ConfigurationError
from t2l.tasks.block_stack_parameters import BlockStackParameters
from tests.conftest import ROOT, configuration
from tests.fuzz.generate import as_bytes, spoilt
from tests.fuzz.harness import check
from tests.fuzz.test_recordings import QUIET

CONFIGURATION = configuration("studies/smoke")
CONFIGURATION["diagnosis"] = {"recordings": ["logs"]}
CONFIGURATION["deployment"]["workspace_lower_m"] = [-0.5, -0.5, 0.02]
TASK = yaml.safe_load((ROOT / "config/tasks/block_stack.yaml").read_text())


@pytest.fixture(scope="module")
def home(tmp_path_factory) -> Path:
    home = tmp_path_factory.mktemp("home")
    shutil.copytree(ROOT / "config/tasks", home / "config/tasks")
    (home / "logs").mkdir()
    for suffix in ("csv", "yaml"):
        (home / f"logs/a.{suffix}").touch()
    return home


def study(path: str) -> None:
    """As Snakemake does: its messages are exceptions of its own."""
    try:
        content = load(path)
    except CliException as error:
        raise ConfigurationError(str(error)) from None
    read_study(copy.deepcopy(content), Path("config"))


@settings(max_examples=230, **QUIET)
@given(data=st.data())
def test_configurations(home, data):
    document = data.draw(spoilt(CONFIGURATION, Configuration))
    (home / "bad.yaml").write_bytes(data.draw(as_bytes(document)))
    check(lambda: study("bad.yaml"), home, home / "out", ("bad.yaml", "config: "))


@settings(max_examples=60, **QUIET)
@given(data=st.data())
def test_tasks(home, data):
    (home / "sound.yaml").write_text(yaml.safe_dump({**CONFIGURATION, "tasks": ["bad"]}))
    document = data.draw(spoilt(TASK, BlockStackParameters))
    (home / "config/tasks/bad.yaml").write_bytes(data.draw(as_bytes(document)))
    check(lambda: study("sound.yaml"), home, home / "out", ("bad.yaml", "horizon_s"))
