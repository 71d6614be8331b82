"""Typed models of what people write, and messages that name the key, what it holds, what it may.

A model is a subclass of `Typed`; `check` makes one of plain values. What YAML says is taken at its
word: 1.0 is a whole number, "1" is none, true is none.
"""

import difflib
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated, Any, get_args

from pydantic import AfterValidator, BaseModel, BeforeValidator, ConfigDict, ValidationError
from pydantic.fields import FieldInfo
from pydantic_core import PydanticCustomError

from t2l import names

# no quantity of a robot is larger, and its square is a finite float
LARGEST = 1e12
SHOWN_CHARACTERS = 80
SHOWN_PROBLEMS = 20


class Typed(BaseModel):
    """Keys with types; unknown ones are refused."""

    model_config = ConfigDict(extra="forbid", frozen=True, strict=True)


@dataclass(frozen=True)
class Problem:
    """One thing that is wrong: under which key, what is there, what may be (or nothing)."""

    key: str
    found: str
    allowed: str

    def __str__(self) -> str:
        where = f"{self.key}: " if self.key else ""
        return f"{where}found {self.found}" + (f"; allowed: {self.allowed}" if self.allowed else "")


class Invalid(ValueError):  # noqa: N818  # it is no error of its own, but what errors are made of
    """Values that are no such model."""

    def __init__(self, problems: Sequence[Problem]):
        lines = [str(problem) for problem in problems[:SHOWN_PROBLEMS]]
        if len(problems) > SHOWN_PROBLEMS:
            lines.append(f"and {len(problems) - SHOWN_PROBLEMS} more like these")
        super().__init__("\n".join(lines))
        self.problems = list(problems)


def check[M: Typed](model: type[M], values: Any, context: Any = None) -> M:
    """An instance of `model`.

    Args:
        context: what its validators need to know.

    Raises:
        Invalid: with every problem, in the order of the keys.
    """
    if not isinstance(values, Mapping):
        expected = f"the keys {', '.join(_fields(model))}"
        raise Invalid([Problem("", describe(values), expected)])
    try:
        return model.model_validate(dict(values), context=context)
    except ValidationError as error:
        errors = error.errors(include_url=False)
        # a mistyped key explains the one that is missing
        errors.sort(key=lambda e: e["type"] != "extra_forbidden")
        raise Invalid([_problem(model, values, e) for e in errors]) from None


def refuse(allowed: str, found: str = "") -> PydanticCustomError:
    """The error of a validator, to be raised: what would be allowed.

    Args:
        found: what is there, in words; by default the value as it is.
    """
    return PydanticCustomError("refused", "{allowed}", {"allowed": allowed, "found": found})


def describe(value: Any) -> str:
    """A value as a message shows it."""
    if value is None:
        return "nothing"
    try:
        text = repr(value)
    except (ValueError, RecursionError):  # thousands of digits
        return "a value too large to show"
    text = " ".join(text.split())
    return text if len(text) <= SHOWN_CHARACTERS else f"{text[:SHOWN_CHARACTERS]}…"


def suggestion(name: Any, known: Sequence[str]) -> str:
    """A known name close to a mistyped one, as the end of a message; empty if there is none."""
    close = difflib.get_close_matches(str(name)[:SHOWN_CHARACTERS], list(known), n=1)
    return f" (did you mean {close[0]}?)" if close else ""


def is_number(value: Any) -> bool:
    """Whether a value is a finite number of a size that quantities have; true is none."""
    if isinstance(value, bool) or not isinstance(value, int | float):
        return False
    return math.isfinite(value) if isinstance(value, float) else abs(value) <= LARGEST


def _number(value: Any) -> Any:
    if isinstance(value, float) and not math.isfinite(value):
        raise refuse("a finite number")
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise refuse("a number")
    if abs(value) > LARGEST:
        raise refuse(f"a number up to {LARGEST:g}")
    return value


def _whole(value: Any) -> Any:
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise refuse("an integer")
    if isinstance(value, float) and not value.is_integer():
        raise refuse("an integer")
    if abs(value) > LARGEST:
        raise refuse(f"an integer up to {LARGEST:g}")
    return int(value)


def _plain_name(value: str) -> str:
    if not names.is_plain(value) or "." in value:
        raise refuse(f"letters, digits, _ and -, at most {names.MOST_CHARACTERS}")
    return value


def _unique(values: Sequence) -> Sequence:
    if len(set(values)) < len(values):
        raise refuse("a list without repetitions")
    return values


def _tuple(value: Any) -> Any:
    return tuple(value) if isinstance(value, list) else value


# YAML reads the words as text, which they are where a name is meant
_SWITCHES = {"yes": True, "on": True, "no": False, "off": False}


def switch(value: Any) -> Any:
    """A word for true or false as that; anything else as it is."""
    return _SWITCHES.get(value.lower(), value) if isinstance(value, str) else value


Switch = Annotated[bool, BeforeValidator(switch)]
Number = Annotated[int | float, BeforeValidator(_number)]
Integer = Annotated[int, BeforeValidator(_whole)]
Name = Annotated[str, AfterValidator(_plain_name)]
Unique = AfterValidator(_unique)
# YAML has lists only
AsTuple = BeforeValidator(_tuple)


def _problem(model: type[BaseModel], values: Any, error: Mapping[str, Any]) -> Problem:
    kind, context = error["type"], error.get("ctx", {})
    steps = _steps(values, error)
    key, parent = _key(steps), _owner(model, steps[:-1])
    found = describe(error["input"])
    match kind:
        case "extra_forbidden" | "invalid_key":
            known = list(_fields(parent))
            *above, name = steps
            where = _key([*above, str(name)])
            return Problem(where, f"an unknown key{suggestion(name, known)}", ", ".join(known))
        case "missing":
            return Problem(key, "nothing", _allowed_of(parent, steps[-1]))
        case "refused":
            allowed, found = context["allowed"], context["found"] or found
        case "value_error":
            allowed = str(context.get("error", error["msg"]))
        case "greater_than":
            allowed = f"a number above {_limit(context['gt'])}"
        case "greater_than_equal":
            allowed = f"a number from {_limit(context['ge'])} up"
        case "less_than":
            allowed = f"a number below {_limit(context['lt'])}"
        case "less_than_equal":
            allowed = f"a number up to {_limit(context['le'])}"
        case "too_short":
            least = context["min_length"]
            allowed = f"a list with at least {least} element{'s' if least > 1 else ''}"
        case "too_long":
            most = context["max_length"]
            allowed = f"a list with at most {most} element{'s' if most > 1 else ''}"
        case "string_too_short":
            allowed = "text that is not empty"
        case "string_too_long":
            allowed = f"text of at most {context['max_length']} characters"
        case "literal_error":
            allowed = context["expected"].replace("'", "").replace(" or ", ", ")
            known = allowed.split(", ")
            found += suggestion(error["input"], known)
        case _:
            allowed = _KINDS.get(kind, error["msg"])
    return Problem(key, found, allowed)


_OF_KEYS = ("extra_forbidden", "invalid_key", "missing")
_KINDS = {
    "bool_type": "true or false",
    "string_type": "text",
    "string_unicode": "text in Unicode",
    "list_type": "a list",
    "tuple_type": "a list",
    "dict_type": "keys with values",
    "model_type": "keys with values",
    "model_attributes_type": "keys with values",
    "int_type": "an integer",
    "float_type": "a number",
}


def _limit(value: float) -> str:
    return str(value) if isinstance(value, int) else f"{value:g}"


def _key(steps: Sequence) -> str:
    """Keys and indices as a message shows them, each short and in one line."""
    return "".join(
        f"[{step}]" if isinstance(step, int) else f".{_printable(step)}" for step in steps
    ).removeprefix(".")


def _printable(key: str) -> str:
    return (key if key.isprintable() else repr(key)[1:-1])[:SHOWN_CHARACTERS]


def _steps(values: Any, error: Mapping[str, Any]) -> list[str | int]:
    """Keys and indices that lead to an error.

    pydantic names branches of unions, too; they are not in what was given.
    """
    *above, last = error["loc"] or ("",)
    key_is_wrong = error["type"] in _OF_KEYS
    steps = []
    for step in above if key_is_wrong else (*above, last):
        if (isinstance(values, Mapping) and step in values) or _is_index(values, step):
            steps.append(step)
            values = values[step]
    return [*steps, last] if key_is_wrong else steps


def _is_index(values: Any, step: str | int) -> bool:
    return isinstance(values, list | tuple) and isinstance(step, int)


def _owner(model: type[BaseModel], steps: Sequence[str | int]) -> type[BaseModel]:
    """The model that a path of keys and indices leads to, or the last one on the way."""
    for step in steps:
        field = _fields(model).get(str(step))
        model = (field and _model_in(field.annotation)) or model
    return model


def _model_in(kind: Any) -> type[BaseModel] | None:
    """The model that a type is, or is a list, a mapping or a union of."""
    if isinstance(kind, type) and issubclass(kind, BaseModel):
        return kind
    return next(filter(None, map(_model_in, get_args(kind))), None)


def _fields(model: type[BaseModel]) -> dict[str, FieldInfo]:
    """By what they are called in a file."""
    return {field.alias or name: field for name, field in model.model_fields.items()}


def _allowed_of(model: type[BaseModel], key: Any) -> str:
    field = _fields(model).get(str(key))
    return (field.description or "") if field else ""
