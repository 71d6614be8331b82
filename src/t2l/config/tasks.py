"""The task files that a configuration names."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from t2l.documents import read_yaml
from t2l.errors import ConfigurationError, InputError
from t2l.tasks import TASKS, make_task
from t2l.typed import Invalid, Problem, check, describe, suggestion


def read_task(key: str, name: str, folder: Path) -> dict[str, Any]:
    """The checked content of the file `name`.yaml in `folder`, which `key` names.

    Raises:
        ConfigurationError: there is no such file, or with a line for each key that is wrong.
    """
    known = sorted(path.stem for path in folder.glob("*.yaml"))
    if name not in known:
        raise ConfigurationError(
            f"config: {key}: found {describe(name)}{suggestion(name, known)}; allowed: "
            f"{', '.join(known) or 'none'}, the files in {folder}"
        )
    return read_task_file(folder / f"{name}.yaml")


def read_task_file(path: Path, **changes: Any) -> dict[str, Any]:
    """The checked content of a task's file, with some of its keys replaced.

    Raises:
        ConfigurationError: there is no such file, or with a line for each key that is wrong.
    """
    try:
        content = read_yaml(path, "a task")
        if isinstance(content, Mapping):
            content = {**content, **changes}
        task = checked_task(content)
        make_task(task)
    except InputError as error:
        raise ConfigurationError(str(error)) from None
    except ConfigurationError as error:
        raise ConfigurationError(f"{path}: {error}") from None
    except Invalid as error:
        raise ConfigurationError("\n".join(f"{path}: {p}" for p in error.problems)) from None
    except ValueError as error:
        raise ConfigurationError(f"{path}: {error}") from None
    return task


def checked_task(content: Any) -> dict[str, Any]:
    """A task's kind and all of its parameters, from some of them.

    Raises:
        Invalid: with each key that is wrong.
    """
    if not isinstance(content, Mapping):
        raise Invalid([Problem("", describe(content), "the key kind, and what it asks for")])
    content = dict(content)
    kind = content.pop("kind", None)
    names = TASKS.names()
    if not isinstance(kind, str) or kind not in names:
        found = describe(kind) + suggestion(kind, names)
        raise Invalid([Problem("kind", found, ", ".join(names))])
    return {"kind": kind, **check(TASKS.find(kind).parameters, content).model_dump()}
