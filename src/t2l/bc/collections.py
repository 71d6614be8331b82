"""Collections of a task: its demonstrations and its rollouts' starts, drawn anew.

A collection is named as the folder that it has in a study's results. The name is part of every
seed, so each has demonstrations, policies and starts of its own. The first is the task's own
folder: to ask for more of them leaves what was made as it is.
"""

FOLDER = "collection"


def collection(task: str, number: int) -> str:
    """The name of a task's collection, counted from 0."""
    return f"{task}/{FOLDER}{number}" if number else task


def task_of(name: str) -> str:
    """The task that a collection is of."""
    return name.partition("/")[0]
