"""Every known effect: the modules of this package, and files of the user's own.

A class is checked when it is found: what reports print is text, its name can be a file's, and its
parameters have bounds that a fit can work between.
"""

import importlib
import inspect
import math
import pkgutil
from collections.abc import Iterable
from functools import cache
from pathlib import Path
from types import ModuleType

import t2l.effects
from t2l.effects.effect import SIZES, Effect, Parameter
from t2l.effects.expression import VARIABLE, parse
from t2l.errors import ConfigurationError
from t2l.names import ALLOWED, is_plain
from t2l.registry import import_file, python_files
from t2l.typed import describe

TEXTS = ("title", "summary", "signature", "source")
REQUIRED = ("name", "parameters", *TEXTS)
_NOT_EFFECTS = (
    "actuator", "blame", "bristles", "effect", "elements", "exported", "formula", "law", "learned",
    "loop_signals", "registry", "spline_torque", "term", "two_mass", "warming",
)  # fmt: skip


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
    for path in python_files(files):
        for name, effect in _defined_in(import_file(path, "effect"), required=path).items():
            if name in effects:
                raise ConfigurationError(
                    f"effect file {path}: found an effect named {name!r}, which "
                    f"{inspect.getfile(type(effects[name]))} defines too; allowed: another name"
                )
            effects[name] = effect
    return effects


def _defined_in(module: ModuleType, required: Path | None = None) -> dict[str, Effect]:
    found: dict[str, Effect] = {}
    for _, cls in inspect.getmembers(module, inspect.isclass):
        if issubclass(cls, Effect) and cls is not Effect and cls.__module__ == module.__name__:
            where = f"effect {cls.__name__} in {required or module.__file__}"
            missing = [name for name in REQUIRED if not hasattr(cls, name)]
            missing += sorted(cls.__abstractmethods__)
            if missing:
                raise ConfigurationError(f"{where}: lacks `{'`, `'.join(missing)}`")
            _check_class(cls, where)
            if cls.name in found:
                raise ConfigurationError(f"{where}: the name {cls.name!r} is another's in the file")
            try:
                found[cls.name] = cls()
            except (Exception, SystemExit) as error:
                raise ConfigurationError(f"{where}: cannot be made: {error!r}") from None
    if required is not None and not found:
        raise ConfigurationError(f"effect file {required}: defines no subclass of t2l Effect")
    return found


def _check_class(cls: type[Effect], where: str) -> None:
    if not is_plain(cls.name):
        raise ConfigurationError(f"{where}: name: found {describe(cls.name)}; allowed: {ALLOWED}")
    for key in TEXTS:
        value = getattr(cls, key)
        if not isinstance(value, str) or not value.strip():
            raise ConfigurationError(f"{where}: {key}: found {describe(value)}; allowed: text")
    parameters = cls.parameters
    fine = isinstance(parameters, tuple | list) and len(parameters) > 0
    if not fine or not all(isinstance(p, Parameter) for p in parameters):
        raise ConfigurationError(
            f"{where}: parameters: found {describe(parameters)}; allowed: a tuple of `Parameter`, "
            "at least one"
        )
    names = [p.name for p in parameters]
    for parameter in parameters:
        _check_parameter(parameter, f"{where}: parameter {describe(parameter.name)}")
        if names.count(parameter.name) > 1:
            raise ConfigurationError(
                f"{where}: parameters: found {parameter.name!r} twice; allowed: different names"
            )


def _check_parameter(parameter: Parameter, where: str) -> None:
    for key in ("name", "unit", "meaning"):
        value = getattr(parameter, key)
        if not isinstance(value, str) or (key == "name" and not is_plain(value)):
            raise ConfigurationError(f"{where}: {key}: found {describe(value)}; allowed: text")
    lower, upper = parameter.lower, parameter.upper
    for key in ("lower", "upper", "size", "neutral"):
        value = getattr(parameter, key)
        number = isinstance(value, int | float) and not isinstance(value, bool)
        # what is added to the MJCF's may take all of that away
        free = key == "neutral" or (key == "lower" and parameter.adds_to and value == -math.inf)
        if not number or not (free or math.isfinite(value)):
            raise ConfigurationError(
                f"{where}: {key}: found {describe(value)}; allowed: a finite number"
            )
    _check_scale(parameter.scale, where)
    if lower >= upper:
        raise ConfigurationError(
            f"{where}: lower, upper: found {lower}, {upper}; allowed: lower below upper"
        )
    if parameter.log and lower <= 0:
        raise ConfigurationError(
            f"{where}: lower: found {lower}; allowed: above 0, as it is fitted by its logarithm"
        )


def _check_scale(scale: object, where: str) -> None:
    if scale == "":
        return
    try:
        known = isinstance(scale, str) and VARIABLE not in parse(scale, SIZES).split()
    except ValueError:
        known = False
    if not known:
        raise ConfigurationError(
            f"{where}: scale: found {describe(scale)}; allowed: a formula of {', '.join(SIZES)}"
        )
