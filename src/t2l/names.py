"""Names as paths, the one place that says which may be one and where they lead, and in words."""

import re
from collections.abc import Sequence
from pathlib import Path

from t2l.errors import OutputError

# file systems take 255 bytes; an ending and the mark of a draft are added
MOST_CHARACTERS = 100
ALLOWED = f"letters, digits, _, - and ., at most {MOST_CHARACTERS}, not beginning with . or -"
# what is capital in a heading: up to three letters before a number too, mostly those of a model
CAPITAL = re.compile(r"^([a-z]{1,3}(?=\d)|.)")


def is_plain(name: object) -> bool:
    """Whether a name is one part of a path on every system, and nothing else."""
    fine = isinstance(name, str) and re.fullmatch(r"[A-Za-z0-9_][A-Za-z0-9_.-]*", name)
    return bool(fine) and len(name) <= MOST_CHARACTERS


def path_of(folder: Path | str, name: str, suffix: str = "") -> Path:
    """The file of a name in a folder; it never leads out of it.

    Raises:
        OutputError: the name is not plain.
    """
    if not is_plain(name):
        shown = repr(name) if len(str(name)) <= MOST_CHARACTERS else f"{str(name)[:40]!r}…"
        raise OutputError(f"{folder}: found the name {shown}; allowed: {ALLOWED}")
    return Path(folder) / f"{name}{suffix}"


def heading(name: str) -> str:
    """A name from a configuration as a person writes it: `block_stack_ur5e` is Block Stack UR5e."""
    return " ".join(CAPITAL.sub(lambda found: found[0].upper(), part) for part in name.split("_"))


def with_minus(text: str) -> str:
    """Prose with a true minus sign before its negative numbers."""
    return re.sub(r"(?<![\w.)-])-(?=\.?\d)", "−", text)


def listed(words: Sequence[str]) -> str:
    """Words with commas and an "and"."""
    if len(words) < 2:
        return "".join(words)
    return f"{', '.join(words[:-1])} and {words[-1]}"
