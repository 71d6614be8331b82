"""Settings with the defaults of the configuration, where a test does not say otherwise."""

from pathlib import Path

import yaml

from t2l.config import effective
from t2l.hardware.guard import Workspace
from t2l.identify import actuators as identify
from t2l.rl.settings import Search, Settings
from t2l.tasks import Task, make_task

TASKS = Path(__file__).parents[1] / "config/tasks"

DEFAULTS = effective({"study": "tests"})
WORKSPACE = Workspace(
    *(tuple(DEFAULTS["deployment"][f"workspace_{side}_m"]) for side in ("lower", "upper"))
)


def shipped(name: str, **changes) -> Task:
    """A task as its file in config/tasks/ describes it."""
    return make_task({**yaml.safe_load((TASKS / f"{name}.yaml").read_text()), **changes})


def learning(**changes) -> Settings:
    """How policies are trained."""
    section = {k: v for k, v in DEFAULTS["reinforcement_learning"].items() if k != "horizon_s"}
    return Settings(**{**section, **changes})


def search(**changes) -> Search:
    """How action scales are tuned for joint reaching."""
    return Search.from_section({**DEFAULTS["tuning"], **changes}, shipped("joint_reach"))


def identification(**changes) -> identify.Settings:
    """How a simulator is identified."""
    return identify.Settings(**{**DEFAULTS["identification"], **changes})
