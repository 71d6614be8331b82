"""YAML and JSON that people write, read as plain values: bounded, and without surprises.

A document is UTF-8 of at most `MOST_BYTES`. A key that is there twice, an alias of what it stands
in, and more nesting or more nodes than a person writes are refused before anything is built, so
that no document takes long or much memory.

Of YAML, only what looks like a number to everybody is one: 1:30, 010, 0b1 and 1_000 are text, as
are yes, no, on and off (YAML 1.2.2, section 10.3.2, but for 010).

Whatever opens a path of the user's asks here first: a named pipe blocks whoever opens it, and a
device never ends.
"""

import errno
import json
import os
import re
import stat
from collections.abc import Hashable
from pathlib import Path
from typing import Any, BinaryIO

import yaml

from t2l.errors import InputError

# a configuration has 3 kB; what is larger was not written by a person
MOST_BYTES = 1_000_000
# with aliases written out: one node every ten bytes of the largest document
MOST_NODES = 100_000
# of a table: hours of seven joints at 1 kHz, which take 1.6 GB as numbers
MOST_CELLS = 200_000_000
# Python's own limit on nested calls is 1000, and readers of the result need several a level
MOST_LEVELS = 50

_LOADER = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
_TAG = "tag:yaml.org,2002:"
_MERGE = f"{_TAG}merge"
# YAML 1.2.2, section 10.3.2: by tag, what text without quotes is one, and how it begins
_PLAIN = (
    ("null", r"~|null|Null|NULL|", ["~", "n", "N", ""]),
    ("bool", r"true|True|TRUE|false|False|FALSE", list("tTfF")),
    ("int", r"[-+]?(0|[1-9][0-9]*)|0x[0-9a-fA-F]+", list("-+0123456789")),
    (
        "float",
        r"[-+]?(\.[0-9]+|[0-9]+\.[0-9]*)([eE][-+]?[0-9]+)?|[-+]?[0-9]+[eE][-+]?[0-9]+"
        r"|[-+]?\.(inf|Inf|INF)|\.(nan|NaN|NAN)",
        list("-+.0123456789"),
    ),
    ("merge", "<<", ["<"]),
)  # fmt: skip

# by the kind of a file, what it is called
_KINDS = {
    stat.S_IFIFO: "a named pipe (FIFO)",
    stat.S_IFCHR: "a device",
    stat.S_IFBLK: "a device",
    stat.S_IFSOCK: "a socket",
    stat.S_IFDIR: "a folder",
}
REGULAR = "a regular file"

# no path, and nothing that people write, has it
NULL, NULL_FOUND, NULL_ALLOWED = "\0", "a null character in a text", "text without it"


class _Loader(_LOADER):
    """Refuses repeated keys, and takes for a number or a switch what YAML 1.2 does."""

    yaml_implicit_resolvers = {}

    def construct_mapping(self, node: yaml.Node, deep: bool = False) -> dict:
        if isinstance(node, yaml.MappingNode):
            seen = set()
            for key_node, _ in node.value:
                if key_node.tag == _MERGE:  # its keys yield to those that are written out
                    continue
                key = self.construct_object(key_node, deep=True)
                if not isinstance(key, Hashable):
                    raise yaml.MarkedYAMLError(problem="a key that is no text or number",
                                               problem_mark=key_node.start_mark)  # fmt: skip
                if key in seen:
                    raise yaml.MarkedYAMLError(
                        problem=f"the key {str(key)[:80]!r} twice", problem_mark=key_node.start_mark
                    )
                seen.add(key)
        return super().construct_mapping(node, deep=deep)


for _name, _pattern, _first in _PLAIN:
    _Loader.add_implicit_resolver(f"{_TAG}{_name}", re.compile(rf"(?:{_pattern})\Z"), _first)


class _Dumper(yaml.SafeDumper):
    """Quotes text that this loader, or one of YAML 1.1, would read as something else."""

    yaml_implicit_resolvers = {
        first: [
            *yaml.SafeDumper.yaml_implicit_resolvers.get(first, []),
            *_Loader.yaml_implicit_resolvers.get(first, []),
        ]
        for first in {*yaml.SafeDumper.yaml_implicit_resolvers, *_Loader.yaml_implicit_resolvers}
    }


def to_yaml(content: Any, **options: Any) -> str:
    """Plain values as YAML that reads back as what they are; `options` are those of `yaml.dump`."""
    return yaml.dump(content, Dumper=_Dumper, **options)


def is_text(text: str) -> bool:
    """Whether YAML without quotes is read as this text, here and by readers of YAML 1.1."""
    readers = (_Loader, yaml.SafeLoader)
    try:
        return all(yaml.load(text, reader) == text for reader in readers)
    except (yaml.YAMLError, ValueError):
        return False


def check_size(parquet: Any, path: Path | str, error: type[InputError] = InputError) -> None:
    """Refuse a table that is far larger in memory than in its file, before it is read.

    Args:
        parquet: `pyarrow.parquet.ParquetFile`, of which the footer alone has been read.

    Raises:
        InputError: it has more cells than `MOST_CELLS`.
    """
    rows, columns = parquet.metadata.num_rows, parquet.metadata.num_columns
    if rows * columns > MOST_CELLS:
        allowed = f"at most {MOST_CELLS:.0e} cells"
        raise error(path, "the table", f"{rows} rows of {columns} columns", allowed)


def kind_of_file(path: Path | str) -> str | None:
    """What a path leads to that is no regular file; None of one, and where nothing can be seen."""
    try:
        mode = os.stat(path).st_mode
    except (OSError, ValueError):  # ValueError: a path with a null byte
        return None
    return None if stat.S_ISREG(mode) else _kind(mode)


def check_regular(path: Path | str, error: type[InputError] = InputError) -> None:
    """Refuse a path that leads to something which blocks, or never ends, when it is opened.

    For a file that a library opens; `open_regular` opens one itself.

    Raises:
        InputError: or `error`: a pipe, a device, a socket or a folder is there.
    """
    kind = kind_of_file(path)
    if kind is not None:
        raise error(path, "the file", kind, REGULAR)


def open_regular(path: Path | str) -> BinaryIO:
    """A regular file, open to be read; whatever else is there is not waited for.

    Raises:
        InputError: a pipe, a device or a socket is there.
        OSError: it cannot be opened; IsADirectoryError for a folder.
    """
    # a pipe that nobody writes to would block
    descriptor = os.open(path, os.O_RDONLY | os.O_NONBLOCK | os.O_CLOEXEC)
    mode = os.fstat(descriptor).st_mode
    if not stat.S_ISREG(mode):
        os.close(descriptor)
        if stat.S_ISDIR(mode):
            raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR), str(path))
        raise InputError(path, "the file", _kind(mode), REGULAR)
    return open(descriptor, "rb")


def _kind(mode: int) -> str:
    return _KINDS.get(stat.S_IFMT(mode), "what is no file")


def read_text(path: Path | str, purpose: str, most_bytes: int = MOST_BYTES) -> str:
    """The text of a file in UTF-8.

    Args:
        purpose: what the file is for, as the end of a message when it is missing.
        most_bytes: that the file may have.

    Raises:
        InputError: there is no such file, it is a pipe or a device, cannot be read, is too large or
            not UTF-8.
    """
    try:
        with open_regular(path) as file:
            content = file.read(most_bytes + 1)
        if len(content) > most_bytes:
            found = f"more than {most_bytes} bytes"
            raise InputError(path, "the file", found, f"{purpose}, of at most {most_bytes} bytes")
        return content.decode("utf-8-sig")
    except (FileNotFoundError, IsADirectoryError, NotADirectoryError):
        raise InputError(path, "the file", "nothing", purpose) from None
    except UnicodeDecodeError as error:
        found = f"what is not text in UTF-8 (byte {error.start})"
        raise InputError(path, "the file", found, f"{purpose}, in UTF-8") from None
    except (OSError, ValueError) as error:  # ValueError: a path with a null byte
        reason = getattr(error, "strerror", None) or str(error)
        raise InputError(path, "the file", f"what cannot be read ({reason})", purpose) from None


def read_yaml(path: Path | str, purpose: str) -> Any:
    """The content of a YAML file.

    Args:
        purpose: what the file is for, as the end of a message when it is missing.

    Raises:
        InputError: it cannot be read, is not YAML, has a key twice, or is nested without end.
    """
    text = read_text(path, purpose)
    try:
        _check_events(text, Path(path))
        return yaml.load(text, _Loader)
    except (yaml.YAMLError, ValueError, RecursionError, OverflowError) as error:
        reason = _said(error)
        raise InputError(path, "the file", f"what is not YAML ({reason})", "YAML") from None


def read_json(path: Path | str, purpose: str, most_bytes: int = MOST_BYTES) -> Any:
    """The content of a JSON file; likewise.

    Raises:
        InputError: it cannot be read, is not JSON, has a key twice, or is nested without end.
    """
    text = read_text(path, purpose, most_bytes)

    def unique(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
        values = dict(pairs)
        if len(values) < len(pairs):
            keys = [key for key, _ in pairs]
            twice = next(key for key in keys if keys.count(key) > 1)
            raise ValueError(f"the key {twice[:80]!r} twice")
        return values

    try:
        content = json.loads(text, object_pairs_hook=unique)
    except (ValueError, RecursionError) as error:
        reason = _said(error)
        raise InputError(path, "the file", f"what is not JSON ({reason})", "JSON") from None
    if r"\u0000" in text and _has_null(content):
        raise InputError(path, "the file", NULL_FOUND, NULL_ALLOWED)
    return content


def _has_null(content: Any) -> bool:
    if isinstance(content, dict):
        return any(map(_has_null, content)) or any(map(_has_null, content.values()))
    if isinstance(content, list):
        return any(map(_has_null, content))
    return isinstance(content, str) and NULL in content


def _said(error: Exception) -> str:
    """An error in one line; of YAML's, the problem and its line."""
    if isinstance(error, yaml.MarkedYAMLError) and error.problem_mark is not None:
        return f"{error.problem}, line {error.problem_mark.line + 1}"
    if isinstance(error, RecursionError):
        return "too many levels"
    return " ".join(str(error).split())[:300]


def _check_events(text: str, path: Path) -> None:
    """Bound what the parser finds, before anything is built of it."""
    sizes: dict[str, int] = {}  # by anchor, the nodes that an alias of it stands for
    opened: list[tuple[str | None, int]] = []
    nodes = 0

    def refuse(found: str, allowed: str, mark: yaml.Mark) -> None:
        raise InputError(path, f"line {mark.line + 1}", found, allowed)

    for event in yaml.parse(text, _LOADER):
        if isinstance(event, yaml.AliasEvent):
            if event.anchor in {anchor for anchor, _ in opened}:
                refuse(f"*{event.anchor} within itself", "aliases of what is complete",
                       event.start_mark)  # fmt: skip
            nodes += sizes.get(event.anchor, 1)
        elif isinstance(event, yaml.ScalarEvent):
            nodes += 1
            if event.anchor:
                sizes[event.anchor] = 1
            if NULL in event.value:
                refuse(NULL_FOUND, NULL_ALLOWED, event.start_mark)
        elif isinstance(event, yaml.MappingStartEvent | yaml.SequenceStartEvent):
            opened.append((event.anchor, nodes))
            nodes += 1
            if len(opened) > MOST_LEVELS:
                refuse("deeper nesting", f"at most {MOST_LEVELS} levels", event.start_mark)
        elif isinstance(event, yaml.MappingEndEvent | yaml.SequenceEndEvent):
            anchor, before = opened.pop()
            if anchor:
                sizes[anchor] = nodes - before
        if nodes > MOST_NODES:
            refuse("more values, aliases written out", f"at most {MOST_NODES}", event.start_mark)
