"""What is wrong with an action space that a configuration names."""

from collections.abc import Iterator

from t2l.actions import ACTIONS
from t2l.config.models.actions import Actions
from t2l.errors import ConfigurationError
from t2l.sim.controllers import CONTROLLERS
from t2l.typed import Problem, describe, suggestion


def of_actions(key: str, section: Actions, controller: str = "") -> Iterator[Problem]:
    """What is wrong with an action space, which `controller` is to understand if one is named."""
    try:
        space = ACTIONS.find(section.kind)
    except ConfigurationError:
        names = ACTIONS.names()
        near = suggestion(section.kind, names)
        yield Problem(f"{key}.kind", f"{describe(section.kind)}{near}", ", ".join(names))
        return
    if controller and space.controller != controller:
        yield Problem(f"{key}.kind", describe(section.kind), f"an action space for {controller}")
    if section.reference and section.reference not in space.references:
        allowed = ", ".join(space.references) or f"no such key with {section.kind}"
        yield Problem(f"{key}.reference", describe(section.reference), allowed)
    rotation = getattr(section, "rotation", None)
    if rotation and "rotation" not in CONTROLLERS.find(space.controller).settings:
        found = describe(rotation.model_dump())
        yield Problem(f"{key}.rotation", found, f"no such key with {section.kind}")
