"""What commands write: whose a folder is, who is at work in it, and what may be replaced.

An output folder is new, empty, or carries the mark of the same command. The mark, a hidden file,
names the command and what it writes; it is locked while the command runs. What else is in the
folder is not touched. Everything is checked before a command begins its work.
"""

import fcntl
import json
import os
import shutil
import sys
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path

from t2l.artefacts import remove
from t2l.documents import REGULAR, kind_of_file
from t2l.errors import OutputError, writing
from t2l.names import is_plain

MARK = ".t2l"
SHOWN = 3


class AlreadyRunningError(OutputError):
    """Another run works in the same folder."""


@contextmanager
def output_folder(
    folder: Path | str,
    command: str,
    entries: Sequence[str],
    inputs: Iterable[Path | str] = (),
    force: bool | None = False,
    once: bool = False,
) -> Iterator[Path]:
    """Claim a folder for a command while the body runs; nothing is left of it if nothing is made.

    Args:
        command: as the mark and messages name it, such as "t2l compare".
        entries: names of the files, and with a ``/`` at the end of the folders, that it writes.
        inputs: files and folders that are read; none of them may be written.
        force: take a folder that is not the command's own: what another command made there and
            what stands where `entries` go is removed, which is said on standard error. None where
            a command knows no such option.
        once: entries that are there already are not replaced either, unless `force` says so.

    Raises:
        OutputError: the folder is not the command's, an entry is an input or of another kind, or
            nothing can be written there.
        AlreadyRunningError: another process is at work there.
    """
    folder = Path(folder)
    _check(folder, command, entries, inputs, force, once)
    made = _make(folder)
    descriptor = _lock(folder)
    try:
        # another process may have finished since
        replaced = _check(folder, command, entries, inputs, force, once)
        if replaced:
            print(f"{command}: replacing in {folder}: {', '.join(replaced)}", file=sys.stderr)
        for name in replaced:
            remove(folder / name)
        with writing(folder):
            _write_mark(descriptor, command, entries)
        yield folder
    finally:
        with suppress(OSError):
            if os.listdir(folder) == [MARK]:
                (folder / MARK).unlink()
                for path in made:
                    path.rmdir()
        os.close(descriptor)


def claim(folder: Path | str, command: str) -> int:
    """Claim a folder for this process until it ends, however it ends; a file descriptor.

    Raises:
        OutputError: the folder holds what `command` did not put there, or cannot be written.
        AlreadyRunningError: another process is at work there.
    """
    folder = Path(folder)
    _check(folder, command, (), (), force=None, once=False)
    for inside in folder.rglob("*"):
        # its own links lead to what is there, such as the last of some checkpoints
        if inside.is_symlink() and not inside.resolve().is_relative_to(folder.resolve()):
            _refuse_link(inside)
    _make(folder)
    descriptor = _lock(folder)
    with writing(folder):
        _write_mark(descriptor, command, ())
    return descriptor


@contextmanager
def output_file(
    path: Path | str, command: str, inputs: Iterable[Path | str] = (), force: bool = False
) -> Iterator[Path]:
    """Check that a file may be written, before the body writes it.

    Raises:
        OutputError: a folder or an input is there, another file is and `force` is not given, or
            nothing can be written there.
    """
    path = Path(path)
    if path.is_dir():
        raise OutputError(f"{path}: is a folder; allowed: the name of a file")
    if _identity(path) is not None and _identity(path) in _identities(inputs):
        raise OutputError(f"{path}: is read by this command; allowed: another file")
    if os.path.lexists(path):
        if not force:
            raise OutputError(f"{path}: is there already; allowed: a new name, or --force")
        print(f"{command}: replacing {path}", file=sys.stderr)
    made = _make(path.parent)
    try:
        yield path
    finally:
        for folder in made:
            with suppress(OSError):
                folder.rmdir()


def _check(
    folder: Path,
    command: str,
    entries: Sequence[str],
    inputs: Iterable[Path | str],
    force: bool | None,
    once: bool,
) -> list[str]:
    """Whether a command may write into a folder, and which names it has to remove first."""
    if not os.path.lexists(folder):
        return []
    if not folder.is_dir():
        raise OutputError(f"{folder}: is a file; give a folder")
    with writing(folder):
        there = sorted(name for name in os.listdir(folder) if name != MARK)
    known = _identities(inputs)
    if _identity(folder) in known:
        raise OutputError(f"{folder}: is read by this command; allowed: another folder")
    for entry in entries:
        _check_entry(folder, entry, known)
    owner, owned = _read_mark(folder)
    forced = "" if force is None else "; --force replaces what is in the way"
    taken = [entry.rstrip("/") for entry in entries if entry.rstrip("/") in there]
    if owner == command:
        if not once or not taken:
            return []
        if not force:
            raise OutputError(
                f"{folder}: {_some(taken)} there already; allowed: a folder or names that "
                f"are new{forced}"
            )
        return taken
    if not there:
        return []
    if not force:
        whose = f"the results of {owner}" if owner else f"{_some(there)} that it did not make"
        raise OutputError(
            f"{folder}: holds {whose}; allowed: a new or empty folder, or one that "
            f"{command} wrote{forced}"
        )
    return sorted({*taken, *(name for name in owned if name in there)})


def _check_entry(folder: Path, entry: str, known: set) -> None:
    path = folder / entry.rstrip("/")
    if not os.path.lexists(path):
        return
    _refuse_link(path)
    if path.is_dir() != entry.endswith("/"):
        kinds = ("a folder", "a file") if path.is_dir() else ("a file", "a folder")
        raise OutputError(f"{path}: is {kinds[0]} where {kinds[1]} is to be written; move it")
    if _identity(path) in known:
        raise OutputError(f"{path}: is read by this command and would be replaced")
    if path.is_dir():
        for inside in path.rglob("*"):
            _refuse_link(inside)
            if _identity(inside) in known:
                raise OutputError(f"{inside}: is read by this command and could be replaced")


def _refuse_link(path: Path) -> None:
    if path.is_symlink():
        raise OutputError(f"{path}: is a link, which may lead elsewhere; allowed: no such name")


def _identity(path: Path | str) -> tuple[int, int] | None:
    """What a path leads to, through links of either kind."""
    try:
        found = os.stat(path)
    except OSError:
        return None
    return found.st_dev, found.st_ino


def _identities(paths: Iterable[Path | str]) -> set[tuple[int, int] | None]:
    return {_identity(path) for path in paths} - {None}


def _make(folder: Path) -> list[Path]:
    """Make a folder; those that were not there, the innermost first."""
    made = []
    path = folder
    with writing(folder):
        while not path.exists():
            made.append(path)
            path = path.parent
        folder.mkdir(parents=True, exist_ok=True)
    return made


def _lock(folder: Path) -> int:
    path = folder / MARK
    while True:
        _check_mark(path)
        with writing(folder):
            flags = os.O_RDWR | os.O_CREAT | os.O_NOFOLLOW | os.O_NONBLOCK
            descriptor = os.open(path, flags, 0o644)
        try:
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            os.close(descriptor)
            raise AlreadyRunningError(
                f"{folder}: another run is at work here; wait for it or stop it first"
            ) from None
        found = os.fstat(descriptor)
        if found.st_nlink > 1:
            os.close(descriptor)
            raise OutputError(
                f"{path}: is a file of two names, which may be somebody's; allowed: no such name"
            )
        # a run that made nothing may have removed the mark since it was opened
        if _identity(path) == (found.st_dev, found.st_ino):
            return descriptor
        os.close(descriptor)


def _check_mark(path: Path) -> None:
    kind = kind_of_file(path)
    if kind is not None:
        raise OutputError(f"{path}: found {kind}; allowed: {REGULAR}, as t2l writes it")


def _read_mark(folder: Path) -> tuple[str, list[str]]:
    """The command of a folder's mark and the names it writes; "" without a mark of ours."""
    _check_mark(folder / MARK)
    try:
        content = json.loads((folder / MARK).read_text())
        command, entries = str(content["command"]), content["entries"]
        return command, [entry for entry in entries if is_plain(entry)]
    except (OSError, ValueError, KeyError, TypeError):
        return "", []


def _write_mark(descriptor: int, command: str, entries: Sequence[str]) -> None:
    content = {"command": command, "entries": [entry.rstrip("/") for entry in entries]}
    text = (json.dumps(content) + "\n").encode()
    os.pwrite(descriptor, text, 0)
    os.ftruncate(descriptor, len(text))


def _some(names: Sequence[str]) -> str:
    shown = ", ".join(names[:SHOWN])
    return f"{shown} and {len(names) - SHOWN} more" if len(names) > SHOWN else shown


def check_space(folder: Path | str, needed_bytes: int) -> None:
    """Whether a folder's file system has room.

    Raises:
        OutputError: it has not.
    """
    free = shutil.disk_usage(folder).free
    if free < needed_bytes:
        raise OutputError(
            f"{folder}: found {free / 1e6:.3g} MB free; allowed: at least "
            f"{needed_bytes / 1e6:.3g} MB for what is to be written"
        )
