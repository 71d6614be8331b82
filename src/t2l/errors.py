"""Errors that a user can cause: each message says where, what was found, what is allowed."""

import errno
import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path


class T2LError(Exception):
    """Base of every error whose message is meant for the person running t2l."""


class ConfigurationError(T2LError):
    """A configuration key holds something that cannot be run."""


# of each part of what is wrong with a file
MOST_CHARACTERS = 1000


class InputError(ConfigurationError):
    """A file that a person gave holds something that cannot be used."""

    def __init__(self, path: Path | str, where: str, found: str, allowed: str):
        # each may name what somebody has written, of any length
        place, there, instead = (
            text if len(text) <= MOST_CHARACTERS else f"{text[:MOST_CHARACTERS]}…"
            for text in (where, found, allowed)
        )
        super().__init__(f"{path}: {place}: found {there}; allowed: {instead}")
        self.path, self.where, self.found, self.allowed = path, where, found, allowed


class RecordingError(InputError):
    """A recording, or what is to become one, holds something that cannot be used."""


class EffectError(T2LError):
    """A physical effect of the user's own does not do what an effect must."""


class OutputError(T2LError):
    """What is to be written cannot be, or must not be."""


class ArtefactError(T2LError):
    """A file in results/ is truncated, foreign or of another shape than its stage writes.

    Attributes:
        path: the file, or the folder of a data set.
        found, expected: what is wrong.
        complaint: the message without advice.
    """

    def __init__(self, path: Path | str, found: str, expected: str):
        self.path, self.found, self.expected = Path(path), found, expected
        self.complaint = f"{path}: {found}; expected {expected}"
        before = "Move it away and run" if os.path.lexists(path) else "Run"
        super().__init__(f"{self.complaint}. {before} again: it is made anew.")


class ReplayError(T2LError):
    """Too few retargeted demonstrations succeed in a cell to train on."""


class OperatorError(T2LError):
    """An operator succeeds too seldom in a cell to train on."""


class CameraError(T2LError):
    """A camera that is not there, or that sees nothing."""


class RendererError(CameraError):
    """Nothing here can render."""


class ExpertError(T2LError):
    """The expert did not reach the wanted number of successful demonstrations."""


# of a file system that is full, over its quota, read-only or defective
_REFUSED = (errno.ENOSPC, errno.EDQUOT, errno.EROFS, errno.EIO)


@contextmanager
def writing(path: Path | str) -> Iterator[None]:
    """Tell why `path` cannot be written: what the system says, and of which file system.

    Raises:
        OutputError: the body failed with an error of the operating system.
    """
    try:
        yield
    except OSError as error:
        raise cannot_write(error, path) from None


def refused(error: OSError) -> bool:
    """Whether an error says that a file system is full, read-only or defective."""
    return error.errno in _REFUSED


def cannot_write(error: OSError, path: Path | str) -> OutputError:
    """The error of a file that the operating system does not write."""
    if refused(error):
        reason = f"{os.strerror(error.errno)} (the file system at {_mount(Path(path))})"
    else:
        reason = error.strerror or " ".join(str(error).split()) or type(error).__name__
    return OutputError(f"{path}: cannot be written: {reason}")


def _mount(path: Path) -> Path:
    """Where the file system of a path is mounted."""
    path = path.absolute()
    while not path.is_mount():
        path = path.parent
    return path
