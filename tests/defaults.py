"""Settings with the defaults of the configuration, where a test does not say otherwise."""

from t2l.config import effective
from t2l.hardware.guard import Workspace
from t2l.identify import actuators as identify
from t2l.rl.settings import Search, Settings

DEFAULTS = effective({"study": "tests"})
WORKSPACE = Workspace(
    *(tuple(DEFAULTS["deployment"][f"workspace_{side}_m"]) for side in ("lower", "upper"))
)


def learning(**changes) -> Settings:
    """How policies are trained."""
    section = {k: v for k, v in DEFAULTS["reinforcement_learning"].items() if k != "horizon_s"}
    return Settings(**{**section, **changes})


def search(**changes) -> Search:
    """How action scales are tuned for joint reaching."""
    return Search.from_section({**DEFAULTS["tuning"], **changes}, ())


def identification(**changes) -> identify.Settings:
    """How a simulator is identified."""
    return identify.Settings(**{**DEFAULTS["identification"], **changes})
