"""The `robot` section in view of the back end that it names."""

from collections.abc import Sequence
from typing import Any

from t2l.config.models.transfer import RobotSection
from t2l.errors import ConfigurationError
from t2l.gains import Cell
from t2l.hardware import BACKENDS, Features, find_backend
from t2l.robots import ROBOTS, make_robot
from t2l.typed import Invalid, Problem, describe, suggestion


def problems(section: RobotSection, cells: Sequence[Cell]) -> list[Problem]:
    """Everything that is wrong with the section.

    Args:
        cells: that are recorded.
    """
    for key, registry in (("name", ROBOTS), ("backend", BACKENDS)):
        known, value = registry.names(), getattr(section, key)
        if value not in known:
            found = describe(value) + suggestion(value, known)
            return [Problem(f"robot.{key}", found, ", ".join(known))]
    try:
        backend, settings = find_backend(_written(section))
        backend.features(make_robot(section.name), settings)
    except Invalid as error:
        found = error.problems
    except ConfigurationError as error:
        return [Problem("robot", f"what backend {section.backend} cannot drive ({error})", "")]
    else:
        found = backend.problems(settings, cells)
    # another back end may have such a key
    unknown = f"a key that backend {section.backend} does not have"
    return [
        Problem(f"robot.{p.key}", p.found.replace("an unknown key", unknown), p.allowed)
        for p in found
    ]


def features(section: RobotSection) -> Features:
    """What the robot can do, of a section without problems."""
    backend, settings = find_backend(_written(section))
    return backend.features(make_robot(section.name), settings)


def _written(section: RobotSection) -> dict[str, Any]:
    return section.model_dump(exclude_none=True)
