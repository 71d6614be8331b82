"""Where a task's `kind` in config/tasks/ becomes a class."""

from collections.abc import Mapping
from typing import Any

from t2l.tasks.block_stack import BlockStack
from t2l.tasks.task import Task

TASKS: dict[str, type[Task]] = {"block_stack": BlockStack}


def make_task(parameters: Mapping[str, Any]) -> Task:
    """The task that a validated file of config/tasks/ describes."""
    parameters = dict(parameters)
    return TASKS[parameters.pop("kind")](**parameters)
