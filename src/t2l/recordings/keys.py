"""Typed files of recordings: the first thing that is wrong becomes an error with its key."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from t2l.errors import RecordingError
from t2l.typed import Invalid, Typed, check


def checked[M: Typed](
    model: type[M], values: Any, path: Path | str, prefix: str = "", context: Any = None
) -> M:
    """An instance of `model`; keys without a value are as good as absent.

    Args:
        path: where the values were read, for messages.
        prefix: of the keys in messages, for a section of a file, such as ``gains.``.

    Raises:
        RecordingError: an unknown key, a missing one, or a value that is not allowed.
    """
    if isinstance(values, Mapping):
        values = {key: value for key, value in values.items() if value is not None}
    try:
        return check(model, values, context)
    except Invalid as error:
        first = error.problems[0]
        key = f"{prefix}{first.key}".rstrip(".")
        where = f"key {key}" if key else "the file"
        raise RecordingError(path, where, first.found, first.allowed) from None
