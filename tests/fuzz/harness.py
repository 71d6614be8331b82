"""Runs a command in a folder of its own and looks at how it ended and what it left."""

import contextlib
import io
import os
import signal
import warnings
from collections.abc import Callable, Iterator
from pathlib import Path

from hypothesis import event
from hypothesis.errors import InvalidArgument

from t2l.errors import T2LError

# of the processor, which does not depend on what else runs there; and by the clock, of what waits
LIMIT_S, LONGEST_S = 10, 120


class TooLongError(BaseException):
    """More than `LIMIT_S` or `LONGEST_S`; no handler of the product's may catch it."""


def snapshot(folder: Path) -> dict[str, bytes | None]:
    """Every path below a folder with what it holds."""
    found = {}
    for root, folders, files in os.walk(folder):
        for name in (*folders, *files):
            path = Path(root, name)
            content = path.read_bytes() if path.is_file() else None
            found[str(path)] = os.readlink(path).encode() if path.is_symlink() else content
    return found


def outcome(call: Callable[[], None]) -> str | None:
    """None if it ran, else the one message that it ended with; anything else fails the test."""
    said, shown = io.StringIO(), io.StringIO()
    try:
        with (
            _limited(),
            contextlib.redirect_stderr(said),
            contextlib.redirect_stdout(shown),
            warnings.catch_warnings(action="ignore"),
        ):
            call()
    except T2LError as error:
        message = str(error)
    except SystemExit as error:
        if not error.code:
            return None
        message = error.code if isinstance(error.code, str) else said.getvalue()
    else:
        return None
    assert "Traceback" not in said.getvalue() + message
    assert message.strip(), "no message"
    assert len(message) < 4000, message
    return message


@contextlib.contextmanager
def _limited() -> Iterator[None]:
    def stop(*_) -> None:
        raise TooLongError

    timers = (
        (signal.SIGPROF, signal.ITIMER_PROF, LIMIT_S),
        (signal.SIGALRM, signal.ITIMER_REAL, LONGEST_S),
    )
    before = [signal.signal(number, stop) for number, _, _ in timers]
    for _, timer, limit in timers:
        signal.setitimer(timer, limit)
    try:
        yield
    finally:
        for (number, timer, _), handler in zip(timers, before, strict=True):
            signal.setitimer(timer, 0)
            signal.signal(number, handler)


def check(
    call: Callable[[], None], home: Path, out: Path, names: tuple[str, ...] = ()
) -> str | None:
    """Whether a call runs or ends well, and changes nothing but what is in `out`.

    Args:
        home: the folder it runs in; what is there stays as it is.
        names: of files, one of which a message must name.
    """
    before = snapshot(home)
    here = Path.cwd()
    os.chdir(home)
    try:
        message = outcome(call)
    finally:
        os.chdir(here)
    with contextlib.suppress(InvalidArgument):  # outside of a hypothesis test
        event("ran" if message is None else "told")
    after = snapshot(home)
    mine = {path: content for path, content in after.items() if not _below(path, out)}
    theirs = {path: content for path, content in before.items() if not _below(path, out)}
    assert mine == theirs, set(mine) ^ set(theirs)
    if message is not None and names:
        assert any(name in message for name in names), message
    return message


def _below(path: str, folder: Path) -> bool:
    return path == str(folder) or path.startswith(f"{folder}{os.sep}")
