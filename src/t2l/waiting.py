"""What a person who waits is told and can do: what is waited for, and Ctrl-C that ends at once."""

import os
import signal
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager

PATIENCE_S = 10.0  # after which a person asks what is being done
GRACE_S = 1.5  # from Ctrl-C: a run that has not ended by itself is ended; 2 s are promised
_told: set[str] = set()
_stops_itself = threading.Event()
STATUS = 128 + signal.SIGINT  # what shells expect of a process that Ctrl-C ended


class Interrupted(KeyboardInterrupt):
    """A person pressed Ctrl-C, while `interruptible` watches for it."""


def by_a_person(error: BaseException) -> bool:
    """Whether an exception is a Ctrl-C, and not a KeyboardInterrupt that some code raises."""
    if not isinstance(error, KeyboardInterrupt):
        return False
    ours = isinstance(error, Interrupted)
    return ours or signal.getsignal(signal.SIGINT) is signal.default_int_handler


@contextmanager
def told_if_slow(what: str, after_s: float = PATIENCE_S) -> Iterator[None]:
    """Say on standard error what is waited for, once in a process, if the body takes long."""

    def tell() -> None:
        if what not in _told:
            _told.add(what)
            said = f"waiting for {what} since {after_s:.0f} s; Ctrl-C ends"
            print(said, file=sys.stderr, flush=True)

    timer = threading.Timer(after_s, tell)
    timer.daemon = True
    timer.start()
    try:
        yield
    finally:
        timer.cancel()


@contextmanager
def stopping_itself() -> Iterator[None]:
    """Leave Ctrl-C to the body, however long it takes: a robot is stopped first."""
    _stops_itself.set()
    try:
        yield
    finally:
        _stops_itself.clear()


@contextmanager
def interruptible(said: str) -> Iterator[None]:
    """Let Ctrl-C end the process within 2 s, whatever runs, also threads that nothing stops.

    What is written appears whole or not at all, so an end at any moment loses only what was being
    made. The body sees `Interrupted` first and may end by itself; see `stopping_itself` too.

    Args:
        said: on standard error where the process has to be ended.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    read, write = os.pipe()
    os.set_blocking(write, False)

    def watch() -> None:
        # numbers of signals; 0 at the end of the body. The main thread may be deep in a library
        while (number := os.read(read, 1)) not in (b"\0", b""):
            if number[0] == signal.SIGINT and not _stops_itself.is_set():
                time.sleep(GRACE_S)
                print(f"\n{said}", file=sys.stderr, flush=True)
                os._exit(STATUS)

    def interrupt(*_) -> None:
        raise Interrupted

    handler = signal.signal(signal.SIGINT, interrupt)
    before = signal.set_wakeup_fd(write, warn_on_full_buffer=False)
    threading.Thread(target=watch, daemon=True).start()
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, handler)
        signal.set_wakeup_fd(before)
        os.write(write, b"\0")
