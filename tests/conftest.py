from pathlib import Path

import numpy as np
import pytest
import yaml
from hypothesis import settings

from t2l.config import effective
from t2l.demos.expert import demonstrate
from t2l.tasks import make_task

ROOT = Path(__file__).parents[1]


def configuration(name: str) -> dict:
    """A file of config/, with every default filled in."""
    return effective(yaml.safe_load((ROOT / f"config/{name}.yaml").read_text()))


# The same examples each time, however slow the machine;
# `--hypothesis-profile=default` draws new ones.
settings.register_profile("fixed", derandomize=True, deadline=None)
settings.load_profile("fixed")


@pytest.fixture(scope="session")
def block_stack():
    """Parameters of the task as it ships."""
    return yaml.safe_load((ROOT / "config" / "tasks" / "block_stack.yaml").read_text())


@pytest.fixture(scope="session")
def task(block_stack):
    return make_task(block_stack)


@pytest.fixture(scope="session")
def demonstrations(task):
    return demonstrate(task, count=8, max_attempts=16, rng=np.random.default_rng(7), threads=2)


# files of tests/workflow that share one smoke run
OF_THE_SMOKE_RUN = ("test_kills", "test_slurm", "test_smoke", "test_transfer")


# without pytest-xdist there is nothing to schedule
@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config, log):
    """Files stay together where tests run side by side, and so do all that share one smoke run."""
    from xdist.scheduler import LoadScopeScheduling

    class ByFile(LoadScopeScheduling):
        def _split_scope(self, nodeid):
            file = Path(nodeid.split("::")[0])
            shares = file.parent.name == "workflow" and file.stem in OF_THE_SMOKE_RUN
            return "the smoke run" if shares else str(file)

    return ByFile(config, log)


def pytest_collection_modifyitems(items):
    """What takes longest begins: the smoke run on one processor, other workflows on another."""

    def turn(item):
        workflow = item.path.parent.name == "workflow"
        return not (workflow and item.path.stem in OF_THE_SMOKE_RUN), not workflow

    items.sort(key=turn)
