"""What a terminal is sent: names from files are shown, and never steer it."""

import contextlib
import sys
from collections.abc import Iterator
from typing import TextIO

REWRITE = "\r\033[K"  # of a line of progress, the one that t2l sends itself


def plain(text: str) -> str:
    """A text whose control characters, but line breaks and tabs, are written out."""
    if text.isprintable():
        return text
    kept = ("\n", "\t")
    return "".join(
        c if c in kept or c.isprintable() else c.encode("unicode_escape").decode() for c in text
    )


class Printable:
    """A stream on which everything is printed as `plain` writes it."""

    def __init__(self, stream: TextIO):
        self._stream = stream

    def write(self, text: str) -> int:
        """Write a text; a line that is rewritten begins as it does."""
        begin = REWRITE if text.startswith(REWRITE) else ""
        return self._stream.write(begin + plain(text.removeprefix(REWRITE)))

    def __getattr__(self, name: str):
        return getattr(self._stream, name)


@contextlib.contextmanager
def printable() -> Iterator[None]:
    """Both streams of the process so, while the body runs."""
    with (
        contextlib.redirect_stdout(Printable(sys.stdout)),
        contextlib.redirect_stderr(Printable(sys.stderr)),
    ):
        yield
