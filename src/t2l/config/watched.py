"""Every file that a diagnosis depends on, for a workflow to watch."""

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from t2l.documents import read_yaml
from t2l.errors import T2LError
from t2l.recordings import log
from t2l.registry import python_files
from t2l.robots import ROBOTS, plant


def watched(section: Mapping[str, Any]) -> list[str]:
    """Files of a `diagnosis` section that exist: recordings, their robots, the model, effects.

    What is wrong with one of them is left to be told by the job that reads it.
    """
    recordings = [
        file
        for path in (*section.get("recordings", []), *section.get("holdout", []))
        for file in log.files(path)
    ]
    model = [Path(section["model"])] if section.get("model") else []
    contents = {
        path: _content(path)
        for path in (*recordings, *model)
        if path in model or path.suffix == ".yaml"
    }
    effects = [Path(path) for path in section.get("effects", [])]
    effects += [path.parent / file for path in model for file in _effects(contents[path])]
    # many recordings are of one robot
    robots = dict.fromkeys(_robot(path, content) for path, content in contents.items())
    found = [
        *contents,
        *recordings,
        *python_files(effects),
        *(file for robot in robots for file in _model_files(robot)),
    ]
    return [str(file) for file in dict.fromkeys(found) if file.is_file()]


def _content(path: Path) -> dict[str, Any]:
    try:
        content = read_yaml(path, "a recording or a model")
    except T2LError:
        return {}
    return content if isinstance(content, dict) else {}


def _robot(path: Path, content: Mapping[str, Any]) -> str:
    """The known name or the MJCF that a YAML names; empty if it is neither."""
    robot = content.get("robot")
    if not isinstance(robot, str) or robot in ROBOTS.names():
        return robot if isinstance(robot, str) else ""
    return str((path.parent / robot).resolve())


def _effects(content: Mapping[str, Any]) -> Iterator[str]:
    files = content.get("effect_files")
    return (file for file in (files if isinstance(files, list) else []) if isinstance(file, str))


def _model_files(robot: str) -> list[Path]:
    try:
        return plant.files(robot) if robot else []
    except T2LError:
        return []
