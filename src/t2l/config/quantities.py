"""Types of values that several sections have."""

import unicodedata
from collections.abc import Sequence
from typing import Annotated

from pydantic import AfterValidator, BeforeValidator, Field

from t2l.typed import Number, Unique, refuse

# of a path or an address; Linux takes no path of more than 4096 bytes
MOST_CHARACTERS = 1000
# random generators take 32 bits, and training adds to it
LARGEST_SEED = 2**31 - 1


def _ascending(values: Sequence[float]) -> Sequence[float]:
    if list(values) != sorted(values):
        raise refuse("numbers in ascending order")
    return values


def _bounds(values: Sequence[float]) -> Sequence[float]:
    if values[0] >= values[1]:
        raise refuse("two ascending bounds")
    return values


def _given(value: object) -> object:
    """Refuse an optional key that is there with nothing in it."""
    if value is None:
        raise refuse("a value, or no such key")
    return value


def _written(value: str) -> str:
    if not value.strip() or any(unicodedata.category(c) == "Cc" for c in value):
        raise refuse("text that is not blank, without control characters")
    return value


Positive = Annotated[Number, Field(gt=0)]
# from a millionth to a million: stiffness in N·m/rad, damping in N·m·s/rad
Gain = Annotated[Number, Field(gt=0, ge=1e-6, le=1_000_000)]
# a job each, with its files
Gains = Annotated[list[Gain], Field(min_length=1, max_length=100), Unique]
AscendingGains = Annotated[Gains, AfterValidator(_ascending)]
Bounds = Annotated[list[Positive], Field(min_length=2, max_length=2), AfterValidator(_bounds)]
Point = Annotated[list[Number], Field(min_length=3, max_length=3)]
Text = Annotated[str, Field(max_length=MOST_CHARACTERS), AfterValidator(_written)]
Paths = Annotated[list[Text], Field(min_length=1, max_length=1000), Unique]
Given = BeforeValidator(_given)
