"""Every known effect: the modules of this package, and files of the user's own."""

import importlib
import importlib.util
import inspect
import pkgutil
import sys
from collections.abc import Iterable
from functools import cache
from pathlib import Path
from types import ModuleType

import t2l.effects
from t2l.effects.effect import Effect
from t2l.errors import ConfigurationError

REQUIRED = ("name", "title", "parameters", "summary", "signature", "source")
_NOT_EFFECTS = ("effect", "registry", "term", "two_mass")


@cache
def builtin() -> dict[str, Effect]:
    """The effects of this package by name."""
    effects = {}
    for module in pkgutil.iter_modules(t2l.effects.__path__):
        if module.name not in _NOT_EFFECTS:
            effects |= _defined_in(importlib.import_module(f"t2l.effects.{module.name}"))
    return effects


def load(files: Iterable[Path] = ()) -> dict[str, Effect]:
    """The effects of this package and of `files` (Python files, or folders of them).

    Raises:
        ConfigurationError: a file is missing, fails to import, or defines no effect.
    """
    effects = dict(builtin())
    for file in files:
        for path in sorted(file.glob("*.py")) if file.is_dir() else [file]:
            effects |= _defined_in(_import_file(path), required=path)
    return effects


def _import_file(path: Path) -> ModuleType:
    if not path.is_file():
        raise ConfigurationError(f"effect file {path}: no such file")
    spec = importlib.util.spec_from_file_location(f"t2l_user_effect_{path.stem}", path)
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module  # dataclasses look their module up there
    try:
        spec.loader.exec_module(module)
    except Exception as error:
        raise ConfigurationError(f"effect file {path}: cannot be imported: {error}") from error
    return module


def _defined_in(module: ModuleType, required: Path | None = None) -> dict[str, Effect]:
    found = {}
    for _, cls in inspect.getmembers(module, inspect.isclass):
        if issubclass(cls, Effect) and cls is not Effect and cls.__module__ == module.__name__:
            where = f"effect {cls.__name__} in {required or module.__file__}"
            missing = [name for name in REQUIRED if not hasattr(cls, name)]
            missing += sorted(cls.__abstractmethods__)
            if missing:
                raise ConfigurationError(f"{where}: lacks `{'`, `'.join(missing)}`")
            found[cls.name] = cls()
    if required is not None and not found:
        raise ConfigurationError(f"effect file {required}: defines no subclass of t2l Effect")
    return found
