"""The section `training`, whose keys are those of the policy that it names."""

from collections.abc import Mapping
from importlib.util import find_spec
from typing import Any

from pydantic import Field, create_model

from t2l.config.models import Configuration
from t2l.config.models.cloning import TrainedPolicy, Training
from t2l.policies import POLICIES, ClonedPolicy
from t2l.typed import Invalid, Problem, describe, suggestion


def cloned() -> list[str]:
    """Names of the policies that learn from demonstrations."""
    return [name for name in POLICIES.names() if issubclass(POLICIES.find(name), ClonedPolicy)]


def configuration_model(config: Any) -> type[Configuration]:
    """The model of a configuration, with the settings of its own policy.

    Raises:
        Invalid: no policy that learns from demonstrations has the name, or it needs a package
            that is not installed.
    """
    section = config.get("training") if isinstance(config, Mapping) else None
    name = section.get("policy") if isinstance(section, Mapping) else None
    # what is no name the model tells
    if not isinstance(name, str) or name == Training.model_fields["policy"].default:
        return Configuration
    known = cloned()
    if name not in known:
        found = describe(name) + suggestion(name, known)
        raise Invalid([Problem("training.policy", found, ", ".join(known))])
    policy = POLICIES.find(name)
    if missing := [package for package in policy.packages if not find_spec(package)]:
        found = f"{describe(name)}, which needs {', '.join(missing)}: not installed"
        raise Invalid([Problem("training.policy", found, "pip install 't2l[study]'")])
    training = create_model("Training", __base__=(policy.settings, TrainedPolicy))
    return create_model(
        "Configuration",
        __base__=Configuration,
        training=(training, Field(default_factory=training)),
    )
