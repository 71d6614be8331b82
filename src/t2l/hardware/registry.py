"""Which back ends there are, and the one that a configuration names."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from t2l.errors import ConfigurationError
from t2l.hardware.backend import Backend, BackendError
from t2l.registry import Registry
from t2l.robots import Robot
from t2l.typed import Invalid, Typed, check

BACKENDS: Registry[Backend] = Registry(
    "backend",
    Backend,
    {
        "virtual": "t2l.hardware.virtual:VirtualRobot",
        "aiofranka": "t2l.hardware.franka:AiofrankaRobot",
        "recorded": "t2l.hardware.recorded:RecordedRobot",
    },
)

# of the `robot` section; every other key is the back end's own
SHARED_KEYS = ("name", "backend")


def find_backend(section: Mapping[str, Any]) -> tuple[type[Backend], Typed]:
    """The back end that a `robot` section of a configuration names, and its settings.

    Raises:
        ConfigurationError: there is none of that name.
        Invalid: a key is not one of its own, or holds what it must not.
    """
    backend = BACKENDS.find(section["backend"])
    own = {key: value for key, value in section.items() if key not in SHARED_KEYS}
    return backend, check(backend.settings, own)


def recorded_files(section: Mapping[str, Any], cell: str) -> list[str]:
    """Files that the recording of a cell is taken from, if it is: for a workflow to watch."""
    backend, settings = find_backend(section)
    return [str(path) for path in backend.sources(settings, cell)]


def open_backend(section: Mapping[str, Any], robot: Robot, n: int = 1) -> Backend:
    """Connect to the robots that a configuration names.

    Args:
        section: `robot` of a configuration.
        n: how many are wanted; a back end that drives fewer opens a number that divides it.

    Raises:
        ConfigurationError: the section is wrong, or its back end drives no such robot.
        BackendError: they cannot be reached.
    """
    try:
        backend, settings = find_backend(section)
        most = backend.features(robot, settings).side_by_side or n
        return backend.open(
            robot, settings, max(k for k in range(1, n + 1) if k <= most and not n % k)
        )
    except Invalid as error:
        lines = (f"config: robot.{problem}" for problem in error.problems)
        raise ConfigurationError("\n".join(lines)) from None
    except BackendError as error:
        raise BackendError(f"config: robot: {error}") from error


def truth_of(section: Mapping[str, Any], robot: Robot) -> Mapping[str, np.ndarray]:
    """`Backend.truth` of the robot that a configuration names, for reports."""
    backend, settings = find_backend(section)
    return backend.truth(robot, settings)
