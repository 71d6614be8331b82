"""YAML and JSON that people write, read as plain values: bounded, and without surprises.

A document is UTF-8 of at most `MOST_BYTES`. A key that is there twice, an alias of what it stands
in, and more nesting or more nodes than a person writes are refused before anything is built, so
that no document takes long or much memory.
"""

import json
import re
from collections.abc import Hashable
from pathlib import Path
from typing import Any

import yaml

from t2l.errors import InputError

# a configuration has 3 kB; what is larger was not written by a person
MOST_BYTES = 1_000_000
# with aliases written out: one node every ten bytes of the largest document
MOST_NODES = 100_000
# Python's own limit on nested calls is 1000, and readers of the result need several a level
MOST_LEVELS = 50

_LOADER = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
_DATE = "tag:yaml.org,2002:timestamp"
_MERGE = "tag:yaml.org,2002:merge"
_FLOAT = "tag:yaml.org,2002:float"


class _Loader(_LOADER):
    """Refuses repeated keys, leaves dates as text, and takes 1e-5 for a number."""

    yaml_implicit_resolvers = {
        first: [(tag, pattern) for tag, pattern in resolvers if tag != _DATE]
        for first, resolvers in _LOADER.yaml_implicit_resolvers.items()
    }

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


_Loader.add_implicit_resolver(
    _FLOAT, re.compile(r"[-+]?[0-9]+[eE][-+]?[0-9]+\Z"), list("-+0123456789")
)


def read_text(path: Path | str, purpose: str, most_bytes: int = MOST_BYTES) -> str:
    """The text of a file in UTF-8.

    Args:
        purpose: what the file is for, as the end of a message when it is missing.
        most_bytes: that the file may have.

    Raises:
        InputError: there is no such file, it cannot be read, is too large or not UTF-8.
    """
    try:
        with Path(path).open("rb") as file:
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
        return json.loads(text, object_pairs_hook=unique)
    except (ValueError, RecursionError) as error:
        reason = _said(error)
        raise InputError(path, "the file", f"what is not JSON ({reason})", "JSON") from None


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
