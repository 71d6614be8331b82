"""The task, demonstrations and settings that benchmarks share."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import yaml

from t2l.config import effective
from t2l.demos.demonstration import Demonstration
from t2l.demos.expert import demonstrate
from t2l.tasks import TASKS, Task, make_task

ROOT = Path(__file__).parents[1]


def configuration(name: str = "config") -> dict:
    """A file of config/, with every default filled in."""
    return effective(yaml.safe_load((ROOT / f"config/{name}.yaml").read_text()))


def paper() -> dict:
    """The configuration of the full study."""
    return configuration("studies/paper")


def block_stack() -> Task:
    """Block Stack as it ships."""
    return make_task(task_file("block_stack"))


def task_file(name: str) -> dict:
    """The content of a file of config/tasks/."""
    return yaml.safe_load((ROOT / f"config/tasks/{name}.yaml").read_text())


def tasks(kind: type[Task]) -> Iterator[tuple[str, Task]]:
    """Every task of config/tasks/ of a kind, by name; of those that differ by time, the first."""
    seen = []
    for path in sorted((ROOT / "config/tasks").glob("*.yaml")):
        content = task_file(path.stem)
        scene = {key: value for key, value in content.items() if key != "horizon_s"}
        if issubclass(TASKS.find(content["kind"]), kind) and scene not in seen:
            seen.append(scene)
            yield path.stem, make_task(content)


def demonstrations(task: Task, count: int) -> list[Demonstration]:
    """Successful demonstrations, the same at every call."""
    return demonstrate(task, count, 2 * count, np.random.default_rng(0), threads=2)
