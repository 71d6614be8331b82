"""Reading a YAML mapping key by key, so that every mistake is told with its key."""

import difflib
import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from t2l.errors import RecordingError

LOADER = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
REQUIRED: Any = object()


def read_yaml(path: Path, purpose: str) -> Any:
    """The content of a YAML file.

    Args:
        purpose: what the file is for, as the end of a message when it is missing.

    Raises:
        RecordingError: there is no such file, or it is not YAML.
    """
    try:
        return yaml.load(path.read_text(encoding="utf-8"), LOADER)
    except (FileNotFoundError, IsADirectoryError):
        raise RecordingError(path, "the file", "nothing", purpose) from None
    except (yaml.YAMLError, UnicodeDecodeError) as error:
        reason = " ".join(str(error).split())
        raise RecordingError(path, "the file", f"what is not YAML ({reason})", "YAML") from None


class Keys:
    """The keys of a mapping, each read once and checked; unknown ones are refused at once.

    Args:
        values: what the YAML holds.
        path: the YAML, for messages.
        known: every key that may be there.
        prefix: of the keys in messages, for a section of a file.

    Raises:
        RecordingError: no mapping, or an unknown key.
    """

    def __init__(self, values: Any, path: Path, known: Sequence[str], prefix: str = ""):
        self.path, self.prefix = path, prefix
        if not isinstance(values, Mapping):
            where = f"key {prefix.rstrip('.')}" if prefix else "the file"
            raise RecordingError(path, where, describe(values), f"the keys {', '.join(known)}")
        for key in values:
            if key not in known:
                found = f"an unknown key{suggestion(key, known)}"
                raise self.error(key, found, ", ".join(known))
        self.values = values

    def __contains__(self, key: str) -> bool:
        return self.values.get(key) is not None

    def error(self, key: str, found: str, allowed: str) -> RecordingError:
        """The error about a key, to be raised."""
        return RecordingError(self.path, f"key {self.prefix}{key}", found, allowed)

    def get(self, key: str, allowed: str, default: Any = REQUIRED) -> Any:
        """The value as it is; `default` where there is none."""
        if key in self:
            return self.values[key]
        if default is REQUIRED:
            raise self.error(key, "nothing", allowed)
        return default

    def number(
        self,
        key: str,
        above: float = -math.inf,
        at_least: float = -math.inf,
        default: Any = REQUIRED,
        unit: str = "",
    ) -> float:
        """A finite number within bounds."""
        allowed = f"a number{_bounds(above, at_least)}{_in(unit)}"
        value = self.get(key, allowed, default)
        if value is default:
            return value
        if not is_number(value) or value <= above or value < at_least:
            raise self.error(key, describe(value), allowed)
        return float(value)

    def each(
        self,
        key: str,
        count: int,
        above: float = -math.inf,
        at_least: float = -math.inf,
        unit: str = "",
        default: Any = REQUIRED,
        one_for_all: bool = True,
    ) -> np.ndarray:
        """One number for each of `count` joints, (count,); a single one stands for all of them."""
        bounds = _bounds(above, at_least)
        allowed = f"{count} numbers{bounds}, one for each joint{_in(unit)}"
        if one_for_all:
            allowed = f"one number{bounds}, or {count}, one for each joint{_in(unit)}"
        value = self.get(key, allowed, default)
        numbers = value if isinstance(value, list) else [value] * count if one_for_all else []
        if not numbers or any(not is_number(n) or n <= above or n < at_least for n in numbers):
            raise self.error(key, describe(value), allowed)
        if len(numbers) != count:
            raise self.error(key, f"{len(numbers)} numbers", allowed)
        return np.array(numbers, dtype=float)

    def boolean(self, key: str, default: Any = REQUIRED) -> bool:
        """True or false."""
        value = self.get(key, "true or false", default)
        if not isinstance(value, bool):
            raise self.error(key, describe(value), "true or false")
        return value

    def text(self, key: str, default: Any = REQUIRED, allowed: str = "text") -> str:
        """Text that is not empty, or the default."""
        value = self.get(key, allowed, default)
        if value != default and (not isinstance(value, str) or not value):
            raise self.error(key, describe(value), allowed)
        return value

    def choice(self, key: str, known: Sequence[str], default: Any = REQUIRED) -> str:
        """One of the known words."""
        allowed = ", ".join(known)
        value = self.get(key, allowed, default)
        if value not in known:
            raise self.error(key, f"{describe(value)}{suggestion(value, known)}", allowed)
        return value

    def names(self, key: str, meaning: str = "names") -> tuple[str, ...]:
        """A list of different names, at least one."""
        allowed = f"a list of different {meaning}"
        value = self.get(key, allowed)
        fine = isinstance(value, list) and value and all(isinstance(n, str) and n for n in value)
        if not fine or len(set(value)) < len(value):
            raise self.error(key, describe(value), allowed)
        return tuple(value)

    def section(self, key: str, known: Sequence[str]) -> "Keys":
        """The mapping below a key."""
        value = self.get(key, f"the keys {', '.join(known)}")
        return Keys(value, self.path, known, f"{self.prefix}{key}.")


def describe(value: Any) -> str:
    """A value as a message shows it."""
    return "nothing" if value is None else repr(value)


def suggestion(name: Any, known: Sequence[str]) -> str:
    """A known name close to a mistyped one, as the end of a message; empty if there is none."""
    close = difflib.get_close_matches(str(name), known, n=1)
    return f" (did you mean {close[0]}?)" if close else ""


def is_number(value: Any) -> bool:
    """Whether a YAML value is a finite number; true and false are none."""
    number = isinstance(value, int | float) and not isinstance(value, bool)
    return number and math.isfinite(value)


def _bounds(above: float, at_least: float) -> str:
    if above > -math.inf:
        return f" above {above:g}"
    return f" from {at_least:g} up" if at_least > -math.inf else ""


def _in(unit: str) -> str:
    return f", in {unit}" if unit else ""
