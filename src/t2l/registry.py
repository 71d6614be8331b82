"""Classes behind one interface, by name: the library's, and those of Python files of the user's.

A class of the library is imported when it is asked for, so that a name costs no import. A file of
the user's is loaded once; a class in it that derives from an interface, and has a `name`, is known
to the registry of that interface from then on.
"""

import importlib
import importlib.util
import inspect
import os
import sys
from collections.abc import Collection, Iterable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from types import ModuleType

from t2l.errors import ConfigurationError
from t2l.names import ALLOWED, is_plain
from t2l.typed import describe, suggestion
from t2l.waiting import by_a_person, told_if_slow

TRUST = "T2L_TRUST"  # an environment variable: 1 lets every file run that something names
WOULD_RUN = "Python that would run"
AGREED = (
    "a file that the command itself names, or, once you have read it, --trust of a command of t2l, "
    f"or {TRUST}=1 in the environment"
)
_extensions: dict[Path, ModuleType] = {}


def imported(path: str) -> type:
    """The class of "package.module:Class"."""
    module, _, name = path.partition(":")
    return getattr(importlib.import_module(module), name)


class Registry[T]:
    """The classes that implement an interface.

    Attributes:
        kind: what they are, in messages: `robot`, `task`, ….
        interface: the class that they derive from.
        known: the library's, by name: "package.module:Class".
    """

    def __init__(self, kind: str, interface: type[T], known: Mapping[str, str]):
        self.kind, self.interface, self.known = kind, interface, dict(known)

    def names(self) -> list[str]:
        """Of all classes, the library's first."""
        return [*self.known, *self._extended()]

    def find(self, name: str) -> type[T]:
        """The class of a name.

        Raises:
            ConfigurationError: no class has it.
        """
        if name in self.known:
            return imported(self.known[name])
        extended = self._extended()
        if name not in extended:
            names = self.names()
            raise ConfigurationError(
                f"{self.kind}: found {describe(name)}{suggestion(name, names)}; allowed: "
                f"{', '.join(names)}, or one of a file under `extensions`"
            )
        return extended[name]

    def _extended(self) -> dict[str, type[T]]:
        """The users' classes by name.

        Raises:
            ConfigurationError: one has no name, or one that is taken, or lacks a method.
        """
        found: dict[str, type[T]] = {}
        for path, module in _extensions.items():
            for cls in subclasses_in(module, self.interface):
                where = f"{self.kind} {cls.__name__} in {path}"
                name = getattr(cls, "name", None)
                if not isinstance(name, str) or not is_plain(name):
                    raise ConfigurationError(
                        f"{where}: name: found {describe(name)}; allowed: {ALLOWED}"
                    )
                if name in self.known or name in found:
                    raise ConfigurationError(
                        f"{where}: name: found {name!r}, which another {self.kind} has; allowed: "
                        "another name"
                    )
                found[name] = cls
        return found


def load_extensions(paths: Iterable[Path | str]) -> None:
    """Load Python files, or folders of them; one that is loaded already is not loaded again.

    Raises:
        ConfigurationError: a file is missing, or cannot be imported.
    """
    for path in python_files(paths):
        if path not in _extensions:
            _extensions[path] = import_file(path, "extension")


def python_files(paths: Iterable[Path | str]) -> list[Path]:
    """The files that `paths` name, or those in the folders that they name, absolute, each once."""
    named = (
        file
        for path in map(Path, paths)
        for file in (sorted(path.glob("*.py")) if path.is_dir() else [path])
    )
    return list(dict.fromkeys(file.resolve() for file in named))


@contextmanager
def trusting(everything: bool) -> Iterator[None]:
    """Let every Python file run that something names, also in processes that the body starts."""
    before = os.environ.get(TRUST)
    if everything:
        os.environ[TRUST] = "1"
    try:
        yield
    finally:
        if everything:
            os.environ.pop(TRUST)
            os.environ |= {} if before is None else {TRUST: before}


def untrusted(files: Iterable[Path], named: Collection[Path] = ()) -> list[Path]:
    """Those of `files` that nobody has agreed to run; one that is missing is told elsewhere.

    Args:
        files: absolute paths that something received names.
        named: absolute paths that the person has named in the command.
    """
    if os.environ.get(TRUST) == "1":
        return []
    return [file for file in files if file not in named and file.is_file()]


def check_trusted(files: Iterable[Path], where: str, named: Collection[Path] = ()) -> None:
    """Find Python that nobody has agreed to run, before any of it does.

    Args:
        where: the files are named, for the message.

    Raises:
        ConfigurationError: such a file.
    """
    for file in untrusted(files, named):
        raise ConfigurationError(f"{where}: found {file}, {WOULD_RUN}; allowed: {AGREED}")


def import_file(path: Path, what: str) -> ModuleType:
    """The module of a Python file of the user's.

    Args:
        what: it holds, for messages.

    Raises:
        ConfigurationError: it is missing, no Python, or fails when it is imported.
    """
    if not path.is_file():
        raise ConfigurationError(f"{what} file {path}: no such file")
    spec = importlib.util.spec_from_file_location(f"t2l_user_{path.stem}", path)
    if spec is None or spec.loader is None:
        raise ConfigurationError(f"{what} file {path}: is no Python file; allowed: NAME.py")
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module  # dataclasses look their module up there
    # nothing is to appear beside the file
    before, sys.dont_write_bytecode = sys.dont_write_bytecode, True
    try:
        with told_if_slow(f"{what} file {path}, to import it"):
            spec.loader.exec_module(module)
    # a file that ends the process on import is wrong as any other
    except (Exception, SystemExit, KeyboardInterrupt) as error:
        if by_a_person(error):
            raise
        said = f"{type(error).__name__}: {' '.join(str(error).split())}"
        raise ConfigurationError(f"{what} file {path}: cannot be imported: {said}") from error
    finally:
        sys.dont_write_bytecode = before
    return module


def subclasses_in[T](module: ModuleType, interface: type[T]) -> list[type[T]]:
    """The classes that a module defines, not merely imports, and that derive from `interface`.

    Raises:
        ConfigurationError: one leaves something out that the interface asks for.
    """
    classes = [
        cls
        for _, cls in inspect.getmembers(module, inspect.isclass)
        if issubclass(cls, interface) and cls.__module__ == module.__name__
    ]
    for cls in classes:
        if missing := sorted(getattr(cls, "__abstractmethods__", ())):
            raise ConfigurationError(
                f"{cls.__name__} in {module.__file__}: lacks `{'`, `'.join(missing)}`"
            )
    return classes
