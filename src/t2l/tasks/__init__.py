"""Tasks: a scene, its starts, what a policy sees of it, and when it is solved."""

from t2l.tasks.registry import TASKS, make_task
from t2l.tasks.task import Demonstrated, Monitor, Rewarded, Task

__all__ = ["TASKS", "Demonstrated", "Monitor", "Rewarded", "Task", "make_task"]
